"""``profile``: several axes at once along a motion over time, recorded as streams."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ams.frames import ANGLES, body_rates_rad_s
from ams.models.registry import models_of_name, names_of_rates, senses_rates
from procedures.description.kind_tables import Profile
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.plan.points import Point
from procedures.plan.profiles import profile_deg, range_deg, top_rate_dps
from procedures.plan.steps import Follow
from procedures.solution.bins import profile_observations
from procedures.solution.by_model import solve_by_model
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.rig_file import RigDescription
from rig.errors import RequestRefused
from rig.toml_file import StrictTable

IN_STEP, MOST_IN_STEP = 0.15, 10.0
"""Commands so close to a whole number of samples apart keep step with them; so many samples between do average."""


class ProfileMotion(PointKind):
    """One motion a replication; the solution takes its bins as rows."""

    name = "profile"
    table: tuple[str, type[StrictTable]] | None = ("profile", Profile)

    @property
    def models(self) -> tuple[str, ...]:
        return (*names_of_rates(), "pitch-yaw-roll", "pitch-roll")

    def measures(self, model: str) -> tuple[str, ...]:
        return ("rate",) if senses_rates(model) else ("acceleration",)

    def points(self, request: PlanRequest) -> Sequence[Point]:
        rig, procedure, channels = request.rig, request.procedure, request.channels
        profile = procedure.table_of(Profile)
        assert profile is not None
        voltages = [channel for channel in channels if channel.partition(".")[0] in rig.readouts]
        if voltages:
            raise procedure.error(("profile",), f"{voltages[0]} is no stream: a motion over time is streamed")
        motion = Follow(
            profile.shape,
            profile.duration_s,
            {name: profile.span_deg[name] for name in ANGLES if name in profile.span_deg},
            {name: profile.frequency_hz[name] for name in ANGLES if name in profile.frequency_hz},
            profile.update_s,
            profile.bin_s,
        )
        _refuse_profile(rig, procedure, profile, motion)
        return [(dict.fromkeys(motion.span_deg, 0.0), motion, None)]

    def key_of_angle(self, axis: str) -> Key:
        return "profile", "span_deg", axis

    def solve(self, item: SensorRows) -> SolvedSensor:
        observations = profile_observations(item)
        if not any(model.follows_yaw for model in models_of_name(item.plan.solve.model)):
            observations = replace(observations, yaw_rad=None)
        return solve_by_model(item, observations)


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
    if not senses_rates(procedure.solve.model):
        return
    edges = np.arange(round(profile.duration_s / profile.bin_s) + 1) * profile.bin_s
    indices = np.array(
        [[profile_deg(motion, axis, at) if axis in motion.span_deg else 0.0 for at in edges] for axis in ANGLES]
    )

    euler = np.deg2rad((indices[:, 1:] + indices[:, :-1]) / 2.0).T
    velocity = body_rates_rad_s(euler, np.deg2rad(np.diff(indices)).T / profile.bin_s)
    columns = np.concatenate([np.ones((len(velocity), 1)), velocity / np.abs(velocity).max()], axis=1)
    condition = float(np.linalg.cond(columns))
    if condition > 1e3:
        raise procedure.error(
            ("profile",),
            f"this motion does not turn the angular velocity in three dimensions (condition {condition:.3g}, allowed "
            "1000): a gyro's sensitive axis cannot be determined; use a harmonic motion with a frequency for each axis",
        )


def _refuse_keeping_step(rig: RigDescription, procedure: ProcedureDescription, profile: Profile) -> None:
    """Refuse samples that always meet the same moment between two commands: they see a wrong mean rate."""
    for name, stream in rig.streams.items():
        samples = profile.update_s * stream.samples_hz()
        if samples < MOST_IN_STEP and abs(samples - round(samples)) < IN_STEP:
            raise procedure.error(
                ("profile", "update_s"),
                f"{profile.update_s:g} s are {samples:.3g} samples of {name}: commands and samples keep step, so every "
                f"ramp between two commands is met at the same moments and its mean is wrong; choose one between, such "
                f"as {(round(samples) + 0.7) / stream.samples_hz():.3g} s",
            )


KIND = ProfileMotion()
