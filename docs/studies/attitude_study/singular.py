"""95 % intervals beside singular attitudes: the share of the rows told that hold the truth, by distance."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from attitude_study.tp_figures import Drawing, line
from numpy.typing import NDArray

from ams.attitude.static import Angles, pitch_roll_from_three, pitch_roll_from_two, pitch_with_known_roll
from ams.frames import specific_force
from ams.inference.package.packages import SpreadAngles, angles_from_packages, angles_from_sting
from ams.models.cr import model_gravity_g, sting_gravity_g
from procedures.report.canvas import INK, SERIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
READING_G, SET_G = 1e-3, 5e-4
"""Of a reading, and of offset and of each sensitivity: coarse, so that a singular region is degrees wide."""
K: Final = np.array([[1.0, 0.01, -0.02], [0.02, 1.0, 0.01], [-0.01, 0.02, 1.0]])
SENSORS: Final = [line(row, SET_G**2 * np.eye(4), READING_G) for row in K]
DRAWS: Final = 20_000
DISTANCES_DEG: Final = (0.05, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0,
                        10.0, 15.0, 30.0, 60.0, 90.0)  # fmt: skip
FEWEST_ROWS: Final = 200
"""Of fewer a share says nothing."""
Found = Angles | SpreadAngles
Scene = Callable[[float, np.random.Generator, int], tuple[Found, Mapping[str, FloatArray]]]


def read(indices: Sequence[int], force: FloatArray, chance: np.random.Generator) -> FloatArray:
    """Return (N, S) readings; every row has sensors of its own, as far off as their sets allow."""
    rows = []
    for index in indices:
        wrong = SET_G * chance.normal(size=(len(force), 4))
        clean = wrong[:, 0] + np.einsum("ni,ni->n", force, K[index] + wrong[:, 1:])
        rows.append(clean + READING_G * chance.normal(size=len(force)))
    return np.stack(rows, axis=-1)


def either(chance: np.random.Generator, draws: int) -> FloatArray:
    return np.asarray(chance.choice([-1.0, 1.0], draws))


def by_single(off: float, chance: np.random.Generator, draws: int) -> tuple[Found, Mapping[str, FloatArray]]:
    pitch, roll = (np.pi / 2 - off) * either(chance, draws), chance.uniform(-np.pi, np.pi, draws)
    volts = read([0], specific_force(pitch, roll), chance)[:, 0]
    return pitch_with_known_roll(SENSORS[0], volts, roll), {"pitch": pitch}


def by_pair(indices: tuple[int, int], meeting: float) -> Scene:
    def scene(off: float, chance: np.random.Generator, draws: int) -> tuple[Found, Mapping[str, FloatArray]]:
        pitch, roll = chance.uniform(-1.0, 1.0, draws), meeting - off * np.ones(draws)
        volts = read(indices, specific_force(pitch, roll), chance)
        found = pitch_roll_from_two([SENSORS[index] for index in indices], volts, right_wing_down=meeting > np.pi / 2)
        return found, {"pitch": pitch, "roll": roll}

    return scene


def by_three(off: float, chance: np.random.Generator, draws: int) -> tuple[Found, Mapping[str, FloatArray]]:
    pitch, roll = (np.pi / 2 - off) * either(chance, draws), chance.uniform(-np.pi, np.pi, draws)
    volts = read(range(3), specific_force(pitch, roll), chance)
    return pitch_roll_from_three(SENSORS, volts), {"pitch": pitch, "roll": roll}


def by_packages(off: float, chance: np.random.Generator, draws: int) -> tuple[Found, Mapping[str, FloatArray]]:
    pitch = off * either(chance, draws)
    yaw, roll = chance.uniform(-1.2, 1.2, draws), chance.uniform(-3.1, 3.1, draws)
    if off > 1.5:  # at Θ = 90° a sting at Ψ = 0 stands on its end, where roll is lost
        yaw = np.sign(yaw) * np.maximum(np.abs(yaw), 0.2)
    along = sting_gravity_g(pitch, yaw)
    volts = read(range(3), -along, chance), read(range(3), -model_gravity_g(along, roll), chance)
    return angles_from_packages(SENSORS, SENSORS, *volts), {"pitch": pitch, "yaw": yaw, "roll": roll}


def by_sting(off: float, chance: np.random.Generator, draws: int) -> tuple[Found, Mapping[str, FloatArray]]:
    pitch, yaw = chance.uniform(0.2, 1.0, draws) * either(chance, draws), (np.pi / 2 - off) * either(chance, draws)
    volts = read(range(3), -sting_gravity_g(pitch, yaw), chance)
    return angles_from_sting(SENSORS, volts), {"pitch": pitch, "yaw": yaw}


SCENES: Final[Mapping[str, Scene]] = {
    "x alone, from α = ±90°": by_single,
    "x and y, from R = 90°": by_pair((0, 1), np.pi / 2),
    "x and z, from R = 180°": by_pair((0, 2), np.pi),
    "three axes, from α = ±90°": by_three,
    "sting package, from Ψ = ±90°": by_sting,
    "two packages, from Θ = 0": by_packages,
}


@dataclass(frozen=True)
class Held:
    """Of one scene and distance."""

    unflagged: float
    """Share of the rows."""
    held: Mapping[str, float]
    """By angle, of the rows without a flag: the share whose interval holds the truth; NaN of too few rows."""


def held_at(name: str, off_deg: float, draws: int = DRAWS) -> Held:
    chance = np.random.default_rng([14, list(SCENES).index(name), round(100 * off_deg)])
    found, truth = SCENES[name](np.deg2rad(off_deg), chance, draws)
    is_plain = found.codes == 0
    held = {}
    for angle, true in truth.items():
        off = np.mod(getattr(found, f"{angle}_rad") - true + np.pi, 2.0 * np.pi) - np.pi
        holds = np.abs(off) < getattr(found, f"{angle}_half_95_rad")
        held[angle] = float(holds[is_plain].mean()) if is_plain.sum() >= FEWEST_ROWS else np.nan
    return Held(float(is_plain.mean()), held)


@cache
def measured() -> dict[str, dict[float, Held]]:
    """Return every scene at every distance."""
    return {name: {off: held_at(name, off) for off in DISTANCES_DEG} for name in SCENES}


def table() -> str:
    """Return the shares as a table of the page, a row for each distance."""
    lines = ["| from the singular attitude | " + " | ".join(SCENES) + " |", "|---" * (1 + len(SCENES)) + "|"]
    for off in DISTANCES_DEG:
        cells = []
        for name in SCENES:
            at_distance = measured()[name][off]
            shares = [f"{angle} {100 * share:.1f}" for angle, share in at_distance.held.items() if not np.isnan(share)]
            cells.append(
                f"{100 * at_distance.unflagged:.1f}: {', '.join(shares)}"
                if shares
                else f"{100 * at_distance.unflagged:.1f}"
            )
        lines.append(f"| {off:g}° | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def facts() -> dict[str, object]:
    """Return the table, and how far the shares reach where all rows are told and where some are."""
    classes = [at_distance for by_distance in measured().values() for at_distance in by_distance.values()]
    by_all = [share for at_distance in classes if at_distance.unflagged > 0.998 for share in at_distance.held.values()]
    by_some = [
        share
        for at_distance in classes
        if at_distance.unflagged <= 0.998
        for share in at_distance.held.values()
        if share == share
    ]
    return {
        "singular_table": table(), "draws": f"{DRAWS:,}".replace(",", " "),
        "all_least": 100 * min(by_all), "all_most": 100 * max(by_all),
        "some_least": 100 * min(by_some), "some_most": 100 * max(by_some),
    }  # fmt: skip


def draw(figure: "Figure") -> None:
    for panel, (name, by_distance) in zip(figure.subplots(3, 2, sharex=True).flat, measured().items(), strict=True):
        shares = [100 * at_distance.unflagged for at_distance in by_distance.values()]
        panel.fill_between(DISTANCES_DEG, shares, color="#e3e3e3", linewidth=0.0)
        panel.set(title=name, xscale="log", ylim=(0.0, 100.0), ylabel="without a flag (percent)")
        held = panel.twinx()
        for bound in (94.0, 96.0):
            held.axhline(bound, color=INK, linewidth=0.6, linestyle=":")
        for index, angle in enumerate(next(iter(by_distance.values())).held):
            shares = [100 * at_distance.held[angle] for at_distance in by_distance.values()]
            held.plot(DISTANCES_DEG, shares, color=SERIES[index],
                      linewidth=0.9, marker="o", markersize=2, label=angle)  # fmt: skip
        held.set(ylim=(90.0, 100.0), ylabel="of these, holding (percent)")
        held.legend(loc="lower left", title=None)
    for panel in figure.axes[4:6]:
        panel.set_xlabel("distance (degrees)")


PICTURES: dict[str, tuple[float, Drawing]] = {"beside-singular.png": (6.5, draw)}
