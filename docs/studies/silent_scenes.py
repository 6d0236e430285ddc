"""The cells of the study of silent scenes: which scene at which size in which design, with what declared."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from physics_scenes import SCENES
from silent_declared import BENT, BESIDE, COIL, JOINT, LEVEL, LOST, METER, ORDER, SHIFTED, TABLE, THERMOMETER, USED

CAMPAIGNS = 400


@dataclass(frozen=True)
class Cell:
    """One scene at one size in one design."""

    scene: str
    size: float
    design: Mapping[str, float] = field(default_factory=dict)

    @property
    def key(self) -> str:
        return json.dumps([self.scene, self.size, dict(self.design)])


TABLES = (
    "table-once", "table-twice", "table-harmonics", "table-teeth", "table-worm", "table-smooth-and-teeth",
    "table-once-zeroed", "table-harmonics-zeroed",
)  # fmt: skip
AFTER_EFFECTS = ("after-effect", "after-effect-random-order", "after-effect-raster")
TABLE_SIZES, LIMITS_DEG = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0), (30.0, 60.0, 90.0)
REQUIRED = (
    "clean", "wrong-dwell", "outliers", "outlier-share", "soft-mount", "k2", "k3", "cross-coupling", "k0-asymmetry",
    "k1-asymmetry", "temperature-in-step", "table-wrong-zero", "table-base-tilt", "use-good", "use-dead-axis",
    "use-clipped-z", "use-all-high", "use-site-gravity", "field-coned", "temperature-lag", "temperature-curvature",
    "slip-roll", "slip-pitch", "meter-gain", "two-packages-good", "two-packages-dead-axis",
)  # fmt: skip
FURTHER = (
    "drift-linear", "drift-replications", "drift-sensitivity", "drift-correlated", "temperature-gradient",
    "cross-product", "hysteresis", "table-orthogonality", "wrong-tooth", "swapped-channel", "repeated-reading",
    "drift-step", "drift-warm-up", "drift-in-pitch-order", "field-cross", "field-undeclared", "field-coil-direction",
    "field-coil-current", "temperature-alternating", "temperature-room", "temperature-stratified", "quantisation",
    "temperature-self-heating", "use-shifted-offset", "use-stuck-axis", "use-reversed", "use-swapped",
    "slip-base-sideways", "sensor-offset", "fixture-play", "temperature-daily", "drift-walk", "drift-settling",
    "noisy-replication", "noise-by-attitude", "unrepeatable-index", "carry-over", "after-pitch-moves",
    *AFTER_EFFECTS,
)  # fmt: skip
FEWER: Mapping[str, tuple[float, ...]] = {
    "slip-roll": (0.0, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "slip-pitch": (0.0, 2.0, 5.0, 72.0),
    "meter-gain": (2.0, 10.0, 20.0, 200.0),
    "slip-base-sideways": (2.0, 5.0, 72.0),
    "sensor-offset": (0.5, 2.0, 72.0),
    "fixture-play": (0.5, 2.0, 72.0),
}
"""Of the sizes of a scene, where a campaign of three sensors takes long."""
ALONE: Mapping[str, float] = {"sensors": 1, "reference_every": 0, "check_set": 0}
"""One package, and no reference visit: what its own dwells tell of a table that slips."""
BY_ITSELF: Mapping[str, tuple[float, ...]] = {
    "slip-roll": (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "slip-pitch": (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "slip-base": (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "meter-gain": (2.0, 10.0, 20.0, 200.0),
    "sensor-offset": (0.5, 1.0, 2.0, 5.0, 72.0),
}
PARTIAL: Mapping[str, float] = {"reference_every": 0, "check_before_count": 3}
"""The link was lost inside of the first check set, and nothing is visited in between."""
PARTLY: Mapping[str, tuple[float, ...]] = {
    "slip-roll": (0.0, 2.0, 5.0, 72.0, 720.0),
    "slip-pitch": (5.0, 720.0),
    "meter-gain": (200.0,),
    "sensor-offset": (72.0,),
}
JOINTLY: Sequence[tuple[str, Sequence[float], Mapping[str, float]]] = (
    ("clean", (0.0,), {}),
    ("drift-replications", (0.0, 0.5, 1.0, 2.0, 5.0), {"replications": 2}),
    ("table-once", (0.5, 1.0, 1.5, 3.0), {}),
    ("table-once", (1.5,), {TABLE: 1.5}),
    ("table-harmonics", (1.0,), {}),
    ("table-wrong-zero", (0.5, 1.0), {LEVEL: 1.0}),
    ("table-base-tilt", (1.0,), {LEVEL: 1.0}),
    ("k2", (2.0, 10.0), {}),
    ("cross-coupling", (2.0,), {}),
    ("wrong-dwell", (30.0,), {}),
)
"""Scenes that are solved as package and table together, the designs beside."""
AT_30 = ("soft-mount", "k2", "k3", "cross-coupling", "k0-asymmetry")
BEYOND = ("table-once", "table-twice", "table-once-zeroed")
DECLARED: Sequence[tuple[Sequence[str], Sequence[float], Mapping[str, float]]] = (
    (("table-wrong-zero", "table-base-tilt"), (0.5, 1.0), {LEVEL: 1.0}),
    (("table-base-tilt",), (2.0,), {LEVEL: 2.0}),
    *((("temperature-room",), (size,), {USED: 2.0 * size}) for size in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)),
    (("temperature-room",), (1.0,), {USED: 2.0}),
    (("temperature-stratified",), (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0), {THERMOMETER: 1.0}),
    (("temperature-curvature",), (0.02, 0.05), {ORDER: 2.0}),
    *((BEYOND, (1.5,), {"pitch_limit_deg": limit, TABLE: 1.5}) for limit in LIMITS_DEG),
    (("table-harmonics-zeroed",), (2.0,), {"pitch_limit_deg": 30.0, TABLE: 2.0}),
    (("slip-roll", "slip-pitch", "slip-base"), (0.5, 1.0), {**ALONE, LEVEL: 1.0}),
    (("slip-roll",), (1.0,), {LEVEL: 1.0}),
    *((("meter-gain",), (size,), {**ALONE, METER: size}) for size in (2.0, 10.0)),
    *((("meter-gain",), (size,), {METER: size}) for size in (2.0, 10.0)),
    *((("use-shifted-offset",), (size,), {SHIFTED: size}) for size in (1.0, 2.0, 5.0, 10.0)),
    (("use-dead-axis",), (3e-5,), {LOST: 3e-5}),
    (("drift-settling",), (0.5,), {SHIFTED: 0.83}),
    *((("k0-asymmetry",), (size,), {BENT: 0.5 * size}) for size in (2.0, 5.0)),
    (("k0-asymmetry",), (5.0,), {"pitch_limit_deg": 30.0, BENT: 2.5}),
    (("temperature-gradient",), (2.0,), {BENT: 2.0}),
    (("fixture-play",), (0.5,), {BENT: 1.25}),
    *((AFTER_EFFECTS, (size,), {BENT: size}) for size in (1.0, 2.0, 3.0)),
    (("carry-over",), (3.0,), {BENT: 3.0}),
    *((("after-pitch-moves",), (size,), {BENT: size}) for size in (1.0, 2.0, 5.0)),
    *((("sensor-offset",), (0.5,), {**alone, SHIFTED: 0.5}) for alone in (ALONE, {})),
    *((("field-undeclared",), (size,), {BESIDE: u_ut}) for size, u_ut in ((0.05, 0.015), (0.1, 0.03))),
    (("field-coil-direction",), (0.02,), {COIL: 0.02}),
    *((("two-packages-dead-axis",), (size,), {LOST: size}) for size in (3e-5, 1e-4, 1e-3, 0.01)),
)
"""Scenes at sizes that no test of the data sees, with a limit on what happens declared as well."""


def cells() -> Iterator[Cell]:
    """Yield all cells: thinned out first, so that a part of them has every scene at its threshold."""
    thinned = [
        *_of_tables((1.0, 1.5)),
        *(Cell(scene, size, design) for scenes, sizes, design in DECLARED for scene in scenes for size in sizes),
        *(cell for scene in (*REQUIRED, *FURTHER) for cell in _thinned(_of_scene_alone(scene))),
        *(cell for scene in AT_30 for cell in _thinned(_at_30(scene))),
        *(Cell(scene, size, ALONE) for scene, sizes in BY_ITSELF.items() for size in sizes),
        *(Cell(scene, size, {JOINT: 1.0, **design}) for scene, sizes, design in JOINTLY for size in sizes),
        *(Cell(scene, size, PARTIAL) for scene, sizes in PARTLY.items() for size in sizes),
        *_of_tables((2.0, 0.5)),
    ]
    whole = [
        *(cell for scene in (*REQUIRED, *FURTHER) for cell in _of_scene_alone(scene)),
        *(cell for scene in AT_30 for cell in _at_30(scene)),
        *_of_tables(TABLE_SIZES),
    ]
    yield from {cell.key: cell for cell in (*thinned, *whole)}.values()


def _thinned(every: Sequence[Cell]) -> Sequence[Cell]:
    """Return the cells of nothing, of about the threshold and of the obvious."""
    return [every[index] for index in sorted({0, len(every) // 2 - 1, len(every) // 2, len(every) - 1}) if index >= 0]


def _of_scene_alone(scene: str) -> Sequence[Cell]:
    return [Cell(scene, size) for size in FEWER.get(scene, SCENES[scene].sizes)]


def _at_30(scene: str) -> Sequence[Cell]:
    return [Cell(scene, size, {"pitch_limit_deg": 30.0}) for size in SCENES[scene].sizes]


def _of_tables(sizes: Sequence[float]) -> Iterator[Cell]:
    for size in sizes:
        yield from (Cell(scene, size, {"pitch_limit_deg": limit}) for scene in TABLES for limit in LIMITS_DEG)
