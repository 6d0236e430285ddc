"""Supply and load resistor through a whole run: the coefficients are those at the declared supply and resistor."""

from math import cos, radians
from pathlib import Path

import pytest
from small_run import bench, dwells_of

from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_sensors
from procedures.records.states import State
from procedures.solution.provenance import provenance_of
from procedures.solution.record import read_record
from procedures.solution.request import SolvedSensor

CHANNELS = (
    "channels = { x = { scanner = 1, range_v = 10.0 }",
    "channels = { s = { scanner = 4, range_v = 10.0 }, x = { scanner = 1, range_v = 10.0 }",
)
RATIOMETRIC = 'supply_channel = "dmm.s"\nsupply_nominal_v = 5.0\nratiometric = true\n'
SUPPLY = '[twin.supplies."dmm.s"]\nerror_v = 0.02\ndrift_v_per_replication = 0.03\n'
RESISTOR = 'load_resistor_ohm = 2500.0\nload_resistor_tc_per_degc = 5e-5\nload_resistor_at = "air"\n'
WARMING = "[twin.environment.air]\nnoise_degc = 0.0\ndrift_degc_per_replication = 4.0\n"
TRUE_V_PER_G = {"x": 2.5, "y": 2.48, "z": 2.52}


def _solved(folder: Path, chain: str, truth: str) -> tuple[SolvedSensor, Path]:
    chains = "".join(f'[chain."dmm.{axis}"]\n{chain}' for axis in "xyz")
    tables = (("[twin]\n", f"{chains}[twin]\n"), ("[twin.truth.SN1]", f"{truth}[twin.truth.SN1]"))
    entry = bench(folder, rig=(CHANNELS, *tables))
    assert entry.run(folder / "run").state is State.FINISHED
    sensors = solve_sensors(dwells_of(folder / "run"), entry.rig, entry.plan, "run")
    return sensors["SN1"], folder / "run"


def _sensitivities_v_per_g(solved: SolvedSensor) -> dict[str, float]:
    assert solved.calibration is not None, solved.failure
    return {
        axis: parameter.value
        for axis, result in solved.calibration.axes.items()
        for parameter in result.parameters
        if parameter.name == "sensitivity_v_per_g" and parameter.value is not None
    }


@pytest.mark.parametrize(("chain", "truth"), [(RATIOMETRIC, SUPPLY), (RESISTOR, WARMING)], ids=["supply", "resistor"])
def test_coefficients_hold_at_the_declared_supply_and_resistor(tmp_path: Path, chain: str, truth: str) -> None:
    solved, _ = _solved(tmp_path, chain, truth)
    assert _sensitivities_v_per_g(solved) == pytest.approx(TRUE_V_PER_G, rel=3e-5)
    assert solved.calibration is not None
    for result in solved.calibration.axes.values():
        assert result.standard_error_v < 3e-5  # noise alone: 20 µV a reading, 5 readings a dwell


def test_a_straight_line_holds_at_the_declared_supply_too(tmp_path: Path) -> None:
    """Each axis up and down (SR), while the supply drifts."""
    chains = "".join(f'[chain."dmm.{axis}"]\n{RATIOMETRIC}' for axis in "xyz")
    tables = (("[twin]\n", f"{chains}[twin]\n"), ("[twin.truth.SN1]", f"{SUPPLY}[twin.truth.SN1]"))
    grid = (
        "pitch_deg = { from = -30.0, to = 30.0, step = 30.0 }\nroll_deg = { from = -180.0, to = 90.0, step = 90.0 }\n"
    )
    design = f'kind = "D"\n{grid}'
    kinds = (
        ('kind = "grid"', 'kind = "tumble"'),
        (design, 'kind = "up-down"\norder = "raster"\n'),
        ("[check]\nreference_every = 7\n", '[solve]\nmodel = "linear"\n'),
    )
    entry = bench(tmp_path, rig=(CHANNELS, *tables), procedure=kinds)
    assert entry.run(tmp_path / "run").state is State.FINISHED
    solved = solve_sensors(dwells_of(tmp_path / "run"), entry.rig, entry.plan, "run")["SN1"]
    gains = {
        axis: parameter.value
        for axis, result in solved.calibration.axes.items()  # type: ignore[union-attr]
        for parameter in result.parameters
        if parameter.name.startswith("gain")
    }
    # Up and down tell the part along the axis: cos of the coning angle.
    expected = {"x": 2.5 * cos(radians(0.5)), "y": 2.48 * cos(radians(0.3)), "z": 2.52 * cos(radians(0.4))}
    assert gains == pytest.approx({axis: 1.0 / value for axis, value in expected.items()}, rel=1e-4)


def test_the_set_says_what_readings_were_brought_to(tmp_path: Path) -> None:
    from ams.sets.coefficients import build_set

    solved, run_dir = _solved(tmp_path, RATIOMETRIC + RESISTOR, "")
    with JournalReader.open(run_dir) as reader:
        provenance = provenance_of(solved, read_record(reader))
    assert solved.calibration is not None
    use = build_set(solved.calibration, provenance).document["use"]
    assert isinstance(use, dict)
    corrections = use["chain_corrections"]
    supply = {"channel": "dmm.s", "nominal_v": 5.0}
    resistor = {"ohm": 2500.0, "tc_per_degc": 5e-5, "degc": 23.0}
    assert corrections == {f"dmm.{axis}": {"supply": supply, "load_resistor": resistor} for axis in "xyz"}
    assert str(use["chain_corrections_text"]).startswith("the coefficients hold for reading * nominal_v")
