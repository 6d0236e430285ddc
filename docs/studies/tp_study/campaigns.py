"""TP's calibrations of section 9 as campaigns of the twin, and the reduced designs that are taken out of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from tp_study.laboratory import Campaign, Temperature
from tp_study.printed import ROWS, Row
from tp_study.settings import (
    Truth,
    bias_beyond_noise,
    completed,
    design_basis,
    lack_of_fit_form,
    noise_and_drift,
)

from ams.inputs.request import select_rows
from ams.observations import Observations
from procedures.plan.designs import Design, fractional, tumble

FloatArray = NDArray[np.float64]

XX = np.array([1.0, 0.0, 0.0, -0.5, 0.0])
"""A pad that gives way along x: traceless, the other two axes alike."""
YY = np.array([-0.5, 0.0, 0.0, 1.0, 0.0])
ZZ = np.array([-0.5, 0.0, 0.0, -0.5, 0.0])
XY, XZ = np.eye(5)[1], np.eye(5)[2]
LEVEL = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
"""q_xx = −q_zz: cos 2α of a package without roll."""

GRID = """kind = "D1"
pitch_deg = {{ from = -{0}, to = {0}, step = {1} }}
roll_deg = {{ from = -180.0, to = 180.0, step = {2} }}"""
LINE = 'kind = "D1"\npitch_deg = {{ from = -{0}, to = {0}, step = {1} }}\norder = "forward-reverse"'
DEGC_PER_REPLICATION = 0.2
"""One degree over six replications: TP's 'did not exceed 1 °C'."""


def grid(limit_deg: float, step_deg: float, roll_step_deg: float) -> tuple[FloatArray, FloatArray]:
    """Pitch and roll of a D1 grid with roll repeated at 180°."""
    pitch = np.arange(-limit_deg, limit_deg + 0.5 * step_deg, step_deg)
    pitch_all, roll_all = np.meshgrid(
        pitch, np.arange(-180.0, 180.0 + 0.5 * roll_step_deg, roll_step_deg), indexing="ij"
    )
    return pitch_all.ravel(), roll_all.ravel()


def line(limit_deg: float, step_deg: float) -> tuple[FloatArray, FloatArray]:
    """Pitch there and back, no roll."""
    pitch = np.arange(-limit_deg, limit_deg + 0.5 * step_deg, step_deg)
    both = np.concatenate([pitch, pitch[::-1]])
    return both, np.zeros(both.size)


GRIDS = {
    "22": line(36.0, 2.0),
    "24": line(180.0, 5.0),
    "26": (np.array([-90.0, 0.0, 90.0, 180.0]), np.zeros(4)),
    "28(a)": grid(30.0, 5.0, 15.0),
    "28(b)": grid(30.0, 5.0, 15.0),
    "34": grid(30.0, 5.0, 15.0),
    "37": grid(180.0, 15.0, 30.0),
    "42": grid(180.0, 15.0, 30.0),
    "44": grid(90.0, 10.0, 30.0),
    "47": grid(180.0, 10.0, 30.0),
}
COLUMN = {"x": 1, "y": 2, "z": 3}


def truth_of(figure: str, axis: str = "x", q: FloatArray | None = None) -> Truth:
    """Noise and drift of a row, with a soft mount."""
    row, where = ROWS[figure], GRIDS[figure if figure in GRIDS else figure[:2]]
    basis = design_basis(*where, with_roll=row.parameters == 4)
    bare = noise_and_drift(row, basis, COLUMN[axis])
    return Truth(bare.noise, bare.offset_drift, bare.sensitivity_drift, _five(np.zeros(5) if q is None else q))


def _five(q: FloatArray) -> tuple[float, float, float, float, float]:
    a, b, c, d, e = (float(value) for value in q)
    return a, b, c, d, e


def _mount(diagonal: tuple[Row, FloatArray, FloatArray] | None, rest: tuple[Row, FloatArray, FloatArray]) -> FloatArray:
    """Q from a row whose design sees the diagonal alone (a tumble), then from the row of the full design."""
    known = np.zeros(5)
    for part in (diagonal, rest):
        if part is not None:
            row, form, direction = part
            known = completed(form, known, direction, bias_beyond_noise(row, Truth(row.sigma_prec, 0.0, 0.0)))
    return known


def mount_without_roll() -> FloatArray:
    """cos 2α from the four-point tumble, which sees nothing else; sin 2α from the full turn of figure 24."""
    tumbled = ROWS["26"], lack_of_fit_form(*GRIDS["26"], with_roll=False), LEVEL
    return _mount(tumbled, (ROWS["24"], lack_of_fit_form(*GRIDS["24"], with_roll=False), XZ))


def mount_of_sensor_1() -> FloatArray:
    """sin 2α cos R, two periods in pitch and one in roll as TP saw it, of the size of figure 37."""
    return _mount(None, (ROWS["37"], lack_of_fit_form(*GRIDS["37"], with_roll=True), XZ))


def mount_of_package(axis: str) -> FloatArray:
    """Diagonal from the six-point tumble of figure 50, which sees nothing else; the rest from figure 47."""
    mount, letter = {"x": (XX, "a"), "y": (YY, "b"), "z": (ZZ, "c")}[axis]
    six = np.array([(p.pitch_deg, p.roll_deg) for p in tumble(with_roll=True).points])
    tumbled = ROWS[f"50 {axis}"], lack_of_fit_form(six[:, 0], six[:, 1], with_roll=True), mount
    full = ROWS[f"47({letter})"], lack_of_fit_form(*GRIDS["47"], with_roll=True), XY if axis == "y" else XZ
    return _mount(tumbled, full)


def package(figure: str) -> dict[str, Truth]:
    return {
        axis: truth_of(f"{figure}({letter})", axis, mount_of_package(axis))
        for axis, letter in zip("xyz", "abc", strict=True)
    }


def warm() -> tuple[Truth, Temperature]:
    """Sensor 1 of figure 28: what temperature correction took away is the difference of rows 28(a) and 28(b)."""
    cold, hot = truth_of("28(b)", q=mount_of_sensor_1()), truth_of("28(a)")
    offset, sensitivity = hot.offset_drift - cold.offset_drift, hot.sensitivity_drift - cold.sensitivity_drift
    return cold, Temperature(DEGC_PER_REPLICATION, offset / DEGC_PER_REPLICATION, sensitivity / DEGC_PER_REPLICATION)


def campaigns() -> dict[str, Campaign]:
    """By the figure of TP they begin with."""
    alone, sensor = mount_without_roll(), mount_of_sensor_1()
    sensor_1, feeling = warm()
    made = (
        Campaign("22", {"S0": {"x": truth_of("22", q=alone)}}, LINE.format(36.0, 2.0), 6, with_roll=False),
        Campaign("24", {"S0": {"x": truth_of("24", q=alone)}}, LINE.format(180.0, 5.0), 6, with_roll=False),
        Campaign("26", {"S0": {"x": truth_of("26", q=alone)}}, 'kind = "T"', 6, with_roll=False),
        Campaign(
            "28",
            {"S1": {"x": sensor_1}, "S2": {"x": truth_of("34")}},
            GRID.format(30.0, 5.0, 15.0),
            6,
            temperature={"S1": feeling},
        ),
        Campaign(
            "37",
            {"S1": {"x": truth_of("37", q=sensor)}, "S2": {"x": truth_of("42")}},
            GRID.format(180.0, 15.0, 30.0),
            4,
        ),
        Campaign("44", {"P": package("44")}, GRID.format(90.0, 10.0, 30.0), 6),
        Campaign("47", {"P": package("47")}, GRID.format(180.0, 10.0, 30.0), 6),
    )
    return {campaign.name: campaign for campaign in made}


def reduced_designs() -> dict[str, Design]:
    """Figures 35 and 53, and the tumble of figure 50, all taken out of full data as TP took them."""
    turn = np.arange(-180.0, 181.0, 30.0).tolist()
    return {
        "35": fractional(np.arange(-30.0, 31.0, 15.0).tolist(), turn, (2, 2)),
        "53": fractional(turn, np.arange(-180.0, 181.0, 60.0).tolist(), (2, 2)),
        "50": tumble(with_roll=True),
    }


def taken_out(full: Observations, design: Design) -> Observations:
    """The rows of the full data at the attitudes of a design."""
    wanted = {(round(point.pitch_deg, 6), round(point.roll_deg, 6)) for point in design.points}
    attitudes: Sequence[tuple[float, float]] = list(
        zip(np.rad2deg(full.pitch_rad).round(6).tolist(), np.rad2deg(full.roll_rad).round(6).tolist(), strict=True)
    )
    return select_rows(full, np.array([attitude in wanted for attitude in attitudes]))
