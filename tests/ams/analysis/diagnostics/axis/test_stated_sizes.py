"""What a finding says a term is, against what was put into the output and against the parameter table."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest

CYCLE = {"x": "xyz", "y": "yzx", "z": "zxy"}
SMALL = {"pitch_count": 7, "roll_count": 8, "replications": 4}
SCENES = {
    "K_ii": (lambda i, p, o, _: i * i, {"K2": 1.0}),
    "K_pp": (lambda i, p, o, _: p * p, {"K2": -0.5, "Kpp": 1.0}),  # p² = ½(1 − i²) + ½(p² − o²)
    "K_oo": (lambda i, p, o, _: o * o, {"K2": -0.5, "Kpp": -1.0}),
    "K_ip": (lambda i, p, o, _: i * p, {"Kip": 1.0}),
    "K_io": (lambda i, p, o, _: i * o, {"Kio": 1.0}),
    "K_po": (lambda i, p, o, _: p * o, {"Kpo": 1.0}),
    "K3": (lambda i, p, o, _: i**3, {"K3": 1.0}),
    "K0'": (lambda i, p, o, along: 0.5 * np.sign(np.where(abs(along) > 1e-9, along, 0.0)), {"K0'": 1.0}),
    "K1'": (lambda i, p, o, _: 0.5 * abs(i), {"K1'": 1.0}),
    "K_pp and K3": (lambda i, p, o, _: p * p + i**3, {"K2": -0.5, "Kpp": 1.0, "K3": 1.0}),
}
"""What a sensor adds for each volt a gⁿ, by the accelerations along i, p, o and its own axis,
and the coefficients that this is."""

SYMBOLS = ("K2", "Kpp", "Kip", "Kio", "Kpo", "K3", "K0'", "K1'")


def _told(scene: str, size: float, count: int, seed: int, **design) -> Iterator[tuple[str, float, float, float | None]]:
    """Yield of each significant term its name, its error and ± as printed, V/gⁿ, and how far off the table it is."""
    truth = SCENES[scene][1]
    for axis, found, findings in _findings(scene, size, count, seed, **design):
        in_table = _in_table(found, axis)
        for finding in findings:
            name = str(finding.details["test"])
            said, u = float(finding.details["size"]), float(finding.details["standard_uncertainty"])
            off_table = (said - in_table[name]) / u if name in in_table else None
            yield name, said - size * truth.get(name, 0.0), 2.0 * u, off_table


def _findings(
    scene: str, size: float, count: int, seed: int, **design
) -> Iterator[tuple[str, AxisCalibration, list[Finding]]]:
    """Yield every axis with its significant terms."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(seed), count, **design)
    rows, (added, _) = rows_of(drawn), SCENES[scene]
    force = specific_force(rows.pitch_rad, rows.roll_rad)
    for index in range(count):
        outputs = {}
        for at, axis in enumerate(drawn.setup.axes):
            i, p, o = (force[:, "xyz".index(name)] for name in CYCLE[axis])
            along = force @ drawn.package.axis_direction[index, 0, at]
            outputs[axis] = columns_of(drawn, axis)[:, index] + size * added(i, p, o, along)
        solved = calibrate(replace(rows, outputs=outputs), CalibrationRequest())
        for axis, found in solved.axes.items():
            terms = [one for one in found.findings if one.is_significant and one.details.get("test") in SYMBOLS]
            yield axis, found, terms


def _in_table(found: AxisCalibration, axis: str) -> dict[str, float]:
    values = {parameter.name: parameter.value for parameter in found.parameters}
    xx, xy, xz, yy, yz = (values[f"q_{name}_v_per_g2"] for name in ("xx", "xy", "xz", "yy", "yz"))
    q = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, -xx - yy]])
    i, p, o = ("xyz".index(name) for name in CYCLE[axis])
    return {
        "K2": 1.5 * q[i, i], "Kpp": q[p, p] - q[o, o],
        "Kip": 2.0 * q[i, p], "Kio": 2.0 * q[i, o], "Kpo": 2.0 * q[p, o], "K3": values["k3_v_per_g3"],
    }  # fmt: skip


@pytest.mark.parametrize("size_ug", [100.0, 1000.0])
@pytest.mark.parametrize("scene", SCENES)
def test_a_term_is_as_large_as_it_is_and_as_the_parameter_table_has_it(scene: str, size_ug: float) -> None:
    told = list(_told(scene, 2.5e-6 * size_ug, 5, 1, **SMALL))
    assert {name for name, *_ in told} >= set(SCENES[scene][1])
    assert np.mean([abs(error) <= expanded for _, error, expanded, _ in told]) >= 0.85
    assert max(abs(error) / expanded for _, error, expanded, _ in told) < 2.0
    if not {"K0'", "K1'"} & {name for name, *_ in told}:
        assert max(abs(off) for *_, off in told if off is not None) < 0.05


ALIKE = [("K1'", "K₁′", 20.0), ("K_ii", "K₂", 10.0), ("K0'", "K₀′", 20.0), ("K3", "K₃", 30.0)]


@pytest.mark.parametrize(("scene", "symbol", "size_ug"), ALIKE)
def test_a_term_that_is_there_is_named_where_its_neighbour_looks_like_it(
    scene: str, symbol: str, size_ug: float
) -> None:
    """|a| and a², sgn a and a³: whichever of the two rings, the true one stands in the sentence."""
    told = [terms for _, _, terms in _findings(scene, 2.5e-6 * size_ug, 12, 3, **SMALL) if terms]
    assert len(told) >= 8
    named = [any(symbol in finding.text for finding in terms) for terms in told]
    assert np.mean(named) >= 0.9
    assert all(finding.kind in ("quadratic", "cubic", "asymmetry") for terms in told for finding in terms)


def test_a_bend_that_no_asymmetry_explains_is_told_alone() -> None:
    told = [finding.text for _, _, terms in _findings("K_ii", 2.5e-4, 4, 3, **SMALL) for finding in terms]
    assert any(text.startswith("K₂ = ") for text in told)
    assert not any("K₁′" in text for text in told)


OR_THE_ORDER = "or whatever repeats with the order of the points, which is the same in every replication"


@pytest.mark.parametrize(
    ("order", "is_fixed"), [("raster-and-back", False), ("random", False), ("there-and-back", True)]
)
def test_a_bend_may_be_what_goes_with_the_order_where_that_is_the_same_in_every_replication(
    order: str, is_fixed: bool
) -> None:
    told = [one for _, _, terms in _findings("K_ii", 2.5e-4, 2, 3, **SMALL, order=order) for one in terms]
    assert told
    assert all((OR_THE_ORDER in one.fact) == is_fixed for one in told)
    assert all(('order = "random"' in one.what_to_do) == is_fixed for one in told)


def test_a_hum_that_falls_into_step_with_the_order_passes_for_a_bend_and_is_told_as_what_it_may_be() -> None:
    """Eight rolls a row: what comes round every four dwells is cos 2R, which is a bend of y and z."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(5), 1, **SMALL, order="raster")
    rows = rows_of(drawn)
    turn = np.concatenate([np.arange(count) for count in np.unique(rows.replication, return_counts=True)[1]])
    hum_v = 2.5e-4 * np.cos(0.5 * np.pi * turn)
    outputs = {axis: columns_of(drawn, axis)[:, 0] + hum_v for axis in drawn.setup.axes}
    solved = calibrate(replace(rows, outputs=outputs), CalibrationRequest())
    bends = [one for one in solved.axes["z"].findings if one.is_significant and one.details.get("test") in SYMBOLS]
    assert bends
    assert all(OR_THE_ORDER in one.fact for one in bends)


def test_positions_that_have_one_sign_of_gravity_tell_no_asymmetry_from_a_bend() -> None:
    """At three values of a_i, −1, 0 and 1, |a| is a² in every reading."""
    positions = {"pitch_count": 3, "roll_count": 8, "replications": 6, "pitch_limit_deg": 90.0}
    told = [one for axis, _, terms in _findings("K_ii", 2.5e-3, 2, 3, **positions) if axis == "x" for one in terms]
    assert told
    assert all(", or K₁′: this design does not tell them apart" in one.text for one in told if one.kind == "quadratic")


def test_a_term_that_is_only_just_told_is_said_to_be_told_too_large() -> None:
    """Told because chance lifted it over its bound: the mean of the sizes that are told lies above the truth."""
    size_v = 2.5e-6 * 5.0
    just = [one for _, _, terms in _findings("K_ii", size_v, 30, 3, **SMALL) for one in terms if "K₂" in one.text]
    assert len(just) >= 8
    assert all("only just told" in one.text for one in just)
    sizes = np.array([float(one.details["size"]) for one in just])
    assert sizes.mean() - size_v > 3.0 * sizes.std(ddof=1) / np.sqrt(sizes.size)
    plain = [one for _, _, terms in _findings("K_ii", 2.5e-4, 4, 3, **SMALL) for one in terms if one.text[:2] == "K₂"]
    assert plain
    assert not any("only just told" in one.text for one in plain)


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize("size_ug", [100.0, 500.0, 1000.0])
@pytest.mark.parametrize("scene", SCENES)
def test_what_is_printed_holds_what_there_is_in_a_long_run(scene: str, size_ug: float) -> None:
    """From where a term is plain; near its threshold one that only looks like it may be told."""
    told = list(_told(scene, 2.5e-6 * size_ug, 400, 2))
    assert np.mean([abs(error) <= expanded for _, error, expanded, _ in told]) >= 0.93
