"""Plans of what moves, of applied fields and of long rests: kinds ``rates``, ``profile``, ``two-level`` and ``static``.

Rates: at rest, every axis by itself at every rate in both senses, at rest again. Profile: the whole motion, once a
replication. Two levels: each sensor axis along and against the field, first without, then with it. Static: one rest.
Everything impossible is refused here, before any port is opened.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count, product
from math import ceil, floor

import numpy as np

from ams.arrays import FloatArray
from ams.frames import body_rates_rad_s
from procedures.description.motion import Levels, Profile, Rates
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.plan.channels import AXES, channels_of, sensors_that_measure
from procedures.plan.designs import Design, DesignPoint
from procedures.plan.motion_estimate import expected_motion_duration
from procedures.plan.plan import PLAN_VERSION, Plan
from procedures.plan.profiles import profile_deg, range_deg, top_rate_dps
from procedures.plan.rotations import body_axis, to_stage
from procedures.plan.steps import Applied, Dwell, Follow, Motion, Rest, Step, Turn
from rig.description.rig_file import RigDescription, Sensor
from rig.errors import RequestRefused

MEASURED: Mapping[str, tuple[str, ...]] = {
    "rates": ("rate",),
    "profile": ("rate", "acceleration"),
    "two-level": ("field",),
    "static": ("acceleration", "rate", "field"),
}
"""What a kind calibrates."""
SWEPT_MARGIN_DEG = 1.0
"""Sweeps keep so far from the limits."""
LATENCY_S, LATENCY_SAMPLES = 1.0, 2.0
"""Of a sweep, lost before its first sample is read."""
SWEEP_READ = 0.9
"""Of a sweep, between the margins at its ends where it gathers speed."""
IN_STEP, MOST_IN_STEP = 0.15, 10.0
"""Commands so close to a whole number of samples apart keep step with them; so many samples between do average."""
ALONG = 0.999
"""Cosine of the angle within which an axis stands along a field."""

Point = tuple[dict[str, float], Motion | None, Applied | None]


def make_motion_plan(rig: RigDescription, procedure: ProcedureDescription) -> Plan:
    """The plan of one of these kinds. Raises: PlanError naming file, line and key."""
    kind = procedure.procedure.kind
    sensors = _sensors(rig, procedure)
    axes = tuple(name for name in AXES if name in rig.axes)
    channels = channels_of(rig, sensors)
    makers: Mapping[str, Callable[[], Sequence[Point]]] = {
        "rates": lambda: _rate_points(rig, procedure, channels),
        "profile": lambda: _profile_points(rig, procedure, channels),
        "two-level": lambda: _level_points(rig, procedure, sensors),
        "static": lambda: _static_points(rig, procedure),
    }
    _refuse_ignored_tables(procedure)
    points = makers[kind]()
    _refuse_beyond_limits(rig, procedure, points)
    steps = tuple(_steps(procedure, axes, points))
    return Plan(
        version=PLAN_VERSION,
        title=procedure.procedure.title,
        kind=kind,
        axes=axes,
        sensors=sensors,
        channels=channels,
        settle_channel=channels[0],
        design=_design(points),
        order="raster",
        seed=None,
        replications=procedure.procedure.replications,
        usage_pitch_deg=None,
        dwell=procedure.dwell,
        environment=None,
        reference=None,
        solve=procedure.solve,
        export_formats=procedure.export.formats,
        max_duration_s=procedure.stop.max_duration_s if procedure.stop else None,
        expected=expected_motion_duration(rig, steps, procedure.dwell, channels),
        steps=steps,
        attitude_reference=rig.attitude_reference,
        levels=procedure.levels,
        static=procedure.static,
        most_samples=_most_samples(rig, points),
    )


def _most_samples(rig: RigDescription, points: Sequence[Point]) -> int:
    fastest_hz = max((stream.samples_hz() for stream in rig.streams.values()), default=0.0)
    seconds = [motion.rest_seconds if isinstance(motion, Rest) else motion.seconds for _, motion, _ in points if motion]
    return ceil(max(seconds, default=0.0) * fastest_hz)


def _sensors(rig: RigDescription, procedure: ProcedureDescription) -> dict[str, Sensor]:
    kind, model = procedure.procedure.kind, procedure.solve.model
    wanted = MEASURED[kind]
    if kind == "profile":
        wanted = ("rate",) if model == "gyro" else ("acceleration",)
    sensors = sensors_that_measure(rig, *wanted)
    if not sensors:
        measures = ", ".join(f"{name} ({sensor.measures})" for name, sensor in rig.sensors.items())
        raise procedure.error(
            ("procedure", "kind"),
            f"{kind!r} with model {model!r} calibrates sensors that measure {' or '.join(wanted)}, the rig has "
            f'{measures}; declare measures = "{wanted[0]}" in the rig file, or choose another kind',
        )
    return sensors


def _refuse_ignored_tables(procedure: ProcedureDescription) -> None:
    for table, what in (("environment", "plateaus"), ("check", "reference attitudes")):
        if getattr(procedure, table) is not None:
            raise procedure.error((table,), f"{procedure.procedure.kind!r} has no {what}; remove it")


def _rate_points(rig: RigDescription, procedure: ProcedureDescription, channels: Sequence[str]) -> list[Point]:
    rates = procedure.rates
    assert rates is not None
    _refuse_undetermined(procedure, rates)
    rest: Point = ({}, Rest(rates.dwell_s), None)
    points: list[Point] = [rest] if rates.at_rest else []
    for axis, values in rates.by_axis.items():
        for rate_dps in (sign * value for value in values for sign in (1.0, -1.0)):
            turn = _turn(rig, procedure, rates, axis, rate_dps, channels)
            start_deg = 0.0 if turn.sweep_deg is None else turn.sweep_deg[0]
            points.append(({axis: start_deg}, turn, None))
    return [*points, rest] if rates.at_rest else points


def _turn(
    rig: RigDescription,
    procedure: ProcedureDescription,
    rates: Rates,
    axis: str,
    rate_dps: float,
    channels: Sequence[str],
) -> Turn:
    key = ("rates", f"{axis}_dps")
    if axis not in rig.axes:
        raise procedure.error(key, f"the rig has no axis {axis} (it has: {', '.join(rig.axes)})")
    settings = rig.axes[axis]
    try:
        settings.refuse_rate(axis, rate_dps)
    except RequestRefused as error:
        raise procedure.error(key, str(error)) from None
    if settings.turning == "sweeps":
        return _sweeps(rig, procedure, rates, axis, rate_dps, channels)
    revolutions = ceil(rates.dwell_s * abs(rate_dps) / 360.0 - 1e-9)
    if settings.wrap_turns is not None and revolutions + 1 > settings.wrap_turns:
        raise procedure.error(
            key,
            f"{rates.dwell_s:g} s at {rate_dps:g} deg/s are {revolutions} revolutions and the ramps, the cables bear "
            f"{settings.wrap_turns:g} (axes.{axis}.wrap_turns); nothing moved; shorten dwell_s or turn slower",
        )
    seconds = revolutions * 360.0 / abs(rate_dps)
    return Turn(axis, rate_dps, seconds, revolutions, None, 0, rates.tolerance)


def _sweeps(
    rig: RigDescription,
    procedure: ProcedureDescription,
    rates: Rates,
    axis: str,
    rate_dps: float,
    channels: Sequence[str],
) -> Turn:
    """As many sweeps in one sense as the reading takes."""
    key = ("rates", f"{axis}_dps")
    voltages = [channel for channel in channels if channel.partition(".")[0] in rig.readouts]
    if voltages:
        raise procedure.error(key, f"{axis} sweeps between its limits: {voltages[0]} cannot be read so; use a stream")
    slowest_hz = min(rig.streams[channel.partition(".")[0]].samples_hz() for channel in channels)
    low, high = rig.axes[axis].limits_deg
    ends = (low + SWEPT_MARGIN_DEG, high - SWEPT_MARGIN_DEG)
    inside_s = SWEEP_READ * (ends[1] - ends[0]) / abs(rate_dps) - LATENCY_S - LATENCY_SAMPLES / slowest_hz
    samples = floor(inside_s * slowest_hz)
    if samples < 2:
        raise procedure.error(
            key, f"a sweep of {axis} at {rate_dps:g} deg/s is over in {inside_s:.3g} s, before two samples were read; "
            "turn slower or stream faster",
        )  # fmt: skip
    sweeps = ceil(rates.dwell_s * slowest_hz / samples - 1e-9)
    each = ceil(rates.dwell_s * slowest_hz / sweeps - 1e-9)
    sweep = ends if rate_dps > 0.0 else (ends[1], ends[0])
    return Turn(axis, rate_dps, sweeps * each / slowest_hz, 0, sweep, sweeps, rates.tolerance)


def _refuse_undetermined(procedure: ProcedureDescription, rates: Rates) -> None:
    """A gyro's sensitive axis has three components; each wants an axis that turns."""
    missing = [name for name in AXES if name not in rates.by_axis]
    if procedure.solve.model == "gyro" and missing:
        raise procedure.error(
            ("rates",),
            f'the model "gyro" needs turns about three axes, {" and ".join(missing)} stand still: the sensitivity '
            'along their directions cannot be determined; give rates for them, or use solve.model = "linear"',
        )


def _profile_points(rig: RigDescription, procedure: ProcedureDescription, channels: Sequence[str]) -> list[Point]:
    profile = procedure.profile
    assert profile is not None
    voltages = [channel for channel in channels if channel.partition(".")[0] in rig.readouts]
    if voltages:
        raise procedure.error(("profile",), f"{voltages[0]} is no stream: a motion over time is streamed")
    motion = Follow(
        profile.shape,
        profile.duration_s,
        {name: profile.span_deg[name] for name in AXES if name in profile.span_deg},
        {name: profile.frequency_hz[name] for name in AXES if name in profile.frequency_hz},
        profile.update_s,
        profile.bin_s,
    )
    _refuse_profile(rig, procedure, profile, motion)
    return [(dict.fromkeys(motion.span_deg, 0.0), motion, None)]


def _refuse_profile(rig: RigDescription, procedure: ProcedureDescription, profile: Profile, motion: Follow) -> None:
    for axis in motion.span_deg:
        key = ("profile", "span_deg", axis)
        if axis not in rig.axes:
            raise procedure.error(key, f"the rig has no axis {axis} (it has: {', '.join(rig.axes)})")
        settings = rig.axes[axis]
        if settings.turning != "revolves":
            raise procedure.error(key, f"{axis} is no axis that turns at rates (axes.{axis}: top_rate_dps)")
        try:
            settings.refuse_rate(axis, top_rate_dps(motion, axis))
        except RequestRefused as error:
            raise procedure.error(key, str(error)) from None
        low, high = range_deg(motion, axis)
        if low < settings.limits_deg[0] or high > settings.limits_deg[1]:
            raise procedure.error(
                key,
                f"the motion reaches {low:g}° to {high:g}°, allowed {settings.limits_deg[0]:g} to "
                f"{settings.limits_deg[1]:g}° (axes.{axis}.limits_deg); nothing moved; make it smaller",
            )
    _refuse_keeping_step(rig, procedure, profile)
    if procedure.solve.model != "gyro":
        return
    edges = np.arange(round(profile.duration_s / profile.bin_s) + 1) * profile.bin_s
    places = np.array(
        [[profile_deg(motion, axis, at) if axis in motion.span_deg else 0.0 for at in edges] for axis in AXES]
    )

    euler = np.deg2rad((places[:, 1:] + places[:, :-1]) / 2.0).T
    velocity = body_rates_rad_s(euler, np.deg2rad(np.diff(places)).T / profile.bin_s)
    columns = np.concatenate([np.ones((len(velocity), 1)), velocity / np.abs(velocity).max()], axis=1)
    condition = float(np.linalg.cond(columns))
    if condition > 1e3:
        raise procedure.error(
            ("profile",),
            f"this motion does not turn the angular velocity in three dimensions (condition {condition:.3g}, allowed "
            "1000): a gyro's sensitive axis cannot be determined; use a harmonic motion with a frequency for each axis",
        )


def _refuse_keeping_step(rig: RigDescription, procedure: ProcedureDescription, profile: Profile) -> None:
    """Samples that always meet the same moment between two commands see a wrong mean rate."""
    for name, stream in rig.streams.items():
        samples = profile.update_s * stream.samples_hz()
        if samples < MOST_IN_STEP and abs(samples - round(samples)) < IN_STEP:
            raise procedure.error(
                ("profile", "update_s"),
                f"{profile.update_s:g} s are {samples:.3g} samples of {name}: commands and samples keep step, so every "
                f"ramp between two commands is met at the same moments and its mean is wrong; choose one between, such "
                f"as {(round(samples) + 0.7) / stream.samples_hz():.3g} s",
            )


def _level_points(rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor]) -> list[Point]:
    levels = procedure.levels
    assert levels is not None
    coil = _coil(rig, procedure, levels)
    settings = rig.field[coil]
    for field_ut in levels.applied_ut:
        if not settings.limits_ut[0] <= field_ut <= settings.limits_ut[1]:
            raise procedure.error(
                ("levels", "applied_ut"),
                f"got {field_ut:g} uT, allowed {settings.limits_ut[0]:g} to {settings.limits_ut[1]:g} uT "
                f"(field.{coil}.limits_ut)",
            )
    attitudes = _attitudes_along(rig, procedure, sensors, np.array(settings.direction))
    rest = Rest(levels.rest_s)
    fields = (0.0, *levels.applied_ut)
    return [(attitude, rest, Applied(coil, field_ut)) for field_ut in fields for attitude in attitudes]


def _coil(rig: RigDescription, procedure: ProcedureDescription, levels: Levels) -> str:
    known = ", ".join(rig.field) or "none"
    name = levels.coil or (next(iter(rig.field)) if len(rig.field) == 1 else None)
    if name is None or name not in rig.field:
        raise procedure.error(("levels", "coil"), f"got {levels.coil!r}, the rig has the fields: {known}")
    return name


def _attitudes_along(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor], direction: FloatArray
) -> list[dict[str, float]]:
    """For every axis of every sensor the least turned attitude that lays it along the field, and one against it."""
    unit = direction / np.linalg.norm(direction)
    reachable = [
        [angle for angle in (0.0, 90.0, -90.0, 180.0, -180.0) if low <= angle <= high]
        for low, high in (rig.axes[name].limits_deg if name in rig.axes else (0.0, 0.0) for name in AXES)
    ]
    attitudes = sorted(product(*reachable), key=lambda angles: (sum(map(abs, angles)), angles))
    chosen: list[dict[str, float]] = []
    for serial, sensor in sensors.items():
        for axis, sense in product(sensor.channels, (1.0, -1.0)):
            found = next((one for one in attitudes if _component(sensor, str(axis), one, unit) * sense > ALONG), None)
            if found is None:
                raise procedure.error(
                    ("levels",),
                    f"{serial}.{axis} cannot be laid {'along' if sense > 0.0 else 'against'} the field by attitudes of "
                    "90° within the limits of the axes; turn the coil, or widen limits_deg",
                )
            attitude = {name: angle for name, angle in zip(AXES, found, strict=True) if name in rig.axes}
            if attitude not in chosen:
                chosen.append(attitude)
    return chosen


def _component(sensor: Sensor, axis: str, attitude_deg: tuple[float, ...], level: FloatArray) -> float:
    """Of a level vector along a body axis of the package."""
    return float(body_axis(sensor, axis) @ to_stage(*np.deg2rad(attitude_deg)) @ level)


def _static_points(rig: RigDescription, procedure: ProcedureDescription) -> list[Point]:
    static = procedure.static
    assert static is not None
    wanted = {"pitch": static.pitch_deg, "roll": static.roll_deg}
    for axis, angle in wanted.items():
        if angle != 0.0 and axis not in rig.axes:
            raise procedure.error(("static", f"{axis}_deg"), f"the rig has no axis {axis}")
    return [({name: angle for name, angle in wanted.items() if name in rig.axes}, Rest(static.duration_s), None)]


def _refuse_beyond_limits(rig: RigDescription, procedure: ProcedureDescription, points: Sequence[Point]) -> None:
    for attitude, _, _ in points:
        for axis, angle in attitude.items():
            low, high = rig.axes[axis].limits_deg
            if not low <= angle <= high:
                raise procedure.error(
                    ("procedure", "kind"),
                    f"asks for {axis} {angle:g}°, allowed {low:g} to {high:g}° (axes.{axis}.limits_deg); nothing moved",
                )
    if not points:
        raise PlanError(f"{procedure.path}: nothing to measure")


def _steps(procedure: ProcedureDescription, axes: Sequence[str], points: Sequence[Point]) -> Iterator[Step]:
    numbers = count()
    level = dict.fromkeys(axes, 0.0)
    yield Dwell(next(numbers), "check", 0, 0, level)
    for replication in range(1, procedure.procedure.replications + 1):
        for label, (attitude, motion, applied) in enumerate(points, start=1):
            yield Dwell(next(numbers), "design", replication, label, {**level, **attitude}, motion, applied)


def _design(points: Sequence[Point]) -> Design:
    stops = tuple(
        DesignPoint(label, attitude.get("pitch", 0.0), attitude.get("roll", 0.0), attitude.get("yaw", 0.0))
        for label, (attitude, _, _) in enumerate(points, start=1)
    )
    pitch, roll, yaw = (
        tuple(sorted({getattr(stop, f"{name}_deg") for stop in stops})) for name in ("pitch", "roll", "yaw")
    )
    return Design("schedule", stops, pitch, roll, yaw)
