"""Laws of readings that are compared while a run goes on: a supply that drifts is no fault of anything else."""

from pathlib import Path

import pytest
from report_dwells import dwell
from small_run import bench, resumed

from procedures.journal.journal_reader import JournalReader
from procedures.records.declared_supply import at_declared
from procedures.records.states import State
from procedures.run.judgement.restart_step import compare
from rig.description.signal_chain import Chain

RATIOMETRIC = Chain(ratiometric=True, supply_channel="dmm.s", supply_nominal_v=5.0)
RESISTOR = Chain(load_resistor_ohm=2500.0, load_resistor_tc_per_degc=5e-5, load_resistor_at="air")


def test_readings_are_as_they_would_be_by_declaration_and_the_supply_is_left_out() -> None:
    read = dwell(1, volts={"dmm.x": (2.525, 2.5250001), "dmm.y": (1.0, 1.0), "dmm.s": (5.05, 5.05)}, degc=31.0)
    text = at_declared(read, {"dmm.x": RATIOMETRIC, "dmm.y": RESISTOR})
    assert set(text.readings) == {"dmm.x", "dmm.y"}
    assert text.readings["dmm.x"].samples == pytest.approx([2.5, 2.5000001], rel=1e-9)
    assert text.readings["dmm.y"].mean == pytest.approx(1.0 / 1.0004, rel=1e-12)
    assert read.readings["dmm.x"].mean == pytest.approx(2.52500005)  # what was read stays as it is


@pytest.mark.parametrize("volts", [{"dmm.x": (2.5, 2.5)}, {"dmm.x": (2.5, 2.5), "dmm.s": (float("nan"), 5.0)}])
def test_without_a_supply_a_reading_stays_as_it_is(volts: dict[str, tuple[float, ...]]) -> None:
    assert at_declared(dwell(1, volts=volts), {"dmm.x": RATIOMETRIC}).readings["dmm.x"].mean == 2.5


def test_without_chains_a_record_is_itself() -> None:
    read = dwell(1)
    assert at_declared(read, {}) is read


def test_a_supply_that_drifted_over_a_restart_is_no_step() -> None:
    before = dwell(1, "check", volts={"dmm.x": (2.5, 2.50001, 2.49999), "dmm.s": (5.0, 5.0, 5.0)})
    after = dwell(1, "check", volts={"dmm.x": (2.525, 2.52501, 2.52499), "dmm.s": (5.05, 5.05, 5.05)})
    assert any(entry.is_step for entry in compare({1: before}, {1: after}, []))
    chains = {"dmm.x": RATIOMETRIC}
    found = compare({1: at_declared(before, chains)}, {1: at_declared(after, chains)}, [])
    assert [entry.channel for entry in found] == ["dmm.x"]
    assert not found[0].is_step


def test_a_run_whose_supply_drifts_is_resumed_without_a_step(tmp_path: Path) -> None:
    channels = (
        "channels = { x = { scanner = 1, range_v = 10.0 }",
        "channels = { s = { scanner = 4, range_v = 10.0 }, x = { scanner = 1, range_v = 10.0 }",
    )
    chain = 'supply_channel = "dmm.s"\nsupply_nominal_v = 5.0\nratiometric = true\n'
    chains = "".join(f'[chain."dmm.{axis}"]\n{chain}' for axis in "xyz")
    supply = '[twin.supplies."dmm.s"]\ndrift_v_per_replication = 0.05\n'
    tables = (("[twin]\n", f"{chains}[twin]\n"), ("[twin.truth.SN1]", f"{supply}[twin.truth.SN1]"))
    entry = bench(tmp_path, rig=(channels, *tables), procedure=(("[check]", "[stop]\nmax_duration_s = 60.0\n[check]"),))
    run_dir = tmp_path / "run"
    outcome, processes = entry.run(run_dir), 1
    while outcome.state is State.STOPPED and processes < 9:
        outcome, processes = resumed(run_dir), processes + 1
    assert (outcome.state, outcome.reason) == (State.FINISHED, "")
    assert processes >= 2
    with JournalReader.open(run_dir) as reader:
        seams = [event.detail for event in reader.events("seam")]
    assert len(seams) == processes - 1
    assert all(seam["tested"] and not seam["steps"] for seam in seams)
