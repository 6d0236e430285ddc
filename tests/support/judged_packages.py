"""Packages of ``physics_scenes`` that were calibrated, then used with something wrong, and judged by all their rows."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.calibration.calibrate import calibrate
from ams.inference.inference import Package, inference
from ams.inference.watch.faulty_axis import Judgement
from ams.inference.watch.watched_axes import WatchedAxes
from ams.inputs.request import CalibrationRequest
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance

SENSITIVITY_V_PER_G = 2.5
AXES = "xyz"
CLIPPED = 2
PROVENANCE = Provenance(
    sensor="SN", gravity_mps2=9.80665, gravity_source="declared", pitch_range_deg=(-90.0, 90.0),
    roll_range_deg=(-180.0, 180.0), created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version="0", rig="",
    procedure="", simulated=True,
)  # fmt: skip


def judged(
    scene: str, size: float, sets: int, seed: int, *, at_rest: bool = False, near_level: bool = False
) -> Iterator[tuple[int, Judgement, tuple[str, ...]]]:
    """Yield by set the axis at fault, −1 where none or all are, what the rows tell together, and their flags."""
    use = {"use_rows": 9000, "use_pitch_limit_deg": 1.0} if near_level else {"use_rows": 200}
    chance = np.random.default_rng(seed)
    drawn = campaigns(scene, size, chance, sets, **use)
    kept = np.abs(drawn.use.true_roll_deg[0]) < (1.0 if near_level else 180.0)
    sd_v = np.deg2rad(drawn.use.setup.noise_arcsec / 3600.0) * SENSITIVITY_V_PER_G
    outputs = {axis: columns_of(drawn.calibration, axis) for axis in AXES}
    columns = {axis: f"{axis}_v" for axis in AXES}
    for index in range(sets):
        rows = replace(rows_of(drawn.calibration), outputs={axis: outputs[axis][:, index] for axis in AXES})
        coefficients = build_set(calibrate(rows, CalibrationRequest()), PROVENANCE)
        watched = WatchedAxes(inference(Package(coefficients, columns), reading_sd_v=sd_v))
        read_v = drawn.use.output_v[index, kept, 0]
        if at_rest:
            read_v = read_v[:1] + sd_v * chance.standard_normal(read_v.shape)
        readings = {f"{axis}_v": read_v[:, which] for which, axis in enumerate(AXES)}
        flags = watched.answer(readings).flags
        watched.finish()
        event = drawn.use.event
        axis = CLIPPED if scene == "use-clipped-z" else -1 if event is None else event.axis[index]
        yield int(axis), watched.judged().judgements[0], flags
