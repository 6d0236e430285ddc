"""A thermometer that reads 850 °C once costs its dwell, which is named, and no sensor."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_run import Bench, bench, dwells_of

from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_sensors
from procedures.plan.plan import Plan
from procedures.plan.steps import Rest
from procedures.records.dwells import DwellRecord, Look, Measurement
from procedures.records.states import State
from procedures.solution.provenance import provenance_of
from procedures.solution.record import read_record
from procedures.solution.request import SensorRows, SolvedSensor
from procedures.solution.wild_temperatures import without_wild_temperatures

Measured = tuple[Bench, list[DwellRecord], Path]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Measured:
    """A run in air of 20 ± 3 °C, and its folder."""
    folder = tmp_path_factory.mktemp("wild")
    entry = bench(folder)
    assert entry.run(folder / "run").state is State.FINISHED
    chance, dwells = np.random.default_rng(3), dwells_of(folder / "run")
    read = [replace(dwell, temperature_degc={"air": 20.0 + 3.0 * chance.standard_normal()}) for dwell in dwells]
    return entry, read, folder / "run"


def solved(entry: Bench, dwells: Sequence[DwellRecord]) -> SolvedSensor:
    return solve_sensors(dwells, entry.rig, entry.plan, "run", run="R9")["SN1"]


def with_temperature(plan: Plan, temperature: str) -> Plan:
    return replace(plan, solve=plan.solve.model_copy(update={"temperature": temperature}))


def with_reading(dwells: Sequence[DwellRecord], steps: Sequence[int], degc: float) -> list[DwellRecord]:
    return [replace(dwell, temperature_degc={"air": degc}) if dwell.step in steps else dwell for dwell in dwells]


def design_steps(dwells: Sequence[DwellRecord]) -> list[int]:
    return [dwell.step for dwell in dwells if dwell.accepted and dwell.purpose == "design"]


@pytest.mark.parametrize("temperature", ["none", "estimate"])
def test_its_dwell_is_set_aside_and_named_and_the_sensor_is_solved_from_the_others(
    measured: Measured, temperature: str
) -> None:
    entry, dwells, _ = measured
    entry = replace(entry, plan=with_temperature(entry.plan, temperature))
    step = design_steps(dwells)[4]
    (lost,) = [dwell for dwell in dwells if dwell.step == step]
    found = solved(entry, with_reading(dwells, [step], 850.0))
    without = solved(entry, [dwell for dwell in dwells if dwell.step != step])
    assert found.calibration is not None
    assert without.calibration is not None
    assert found.observations.rows == len(design_steps(dwells)) - 1
    for label, axis in found.calibration.axes.items():
        np.testing.assert_array_equal(axis.primary, without.calibration.axes[label].primary)
        (said,) = [finding for finding in axis.findings if finding.details.get("test") == "temperature of the dwell"]
        assert (said.kind, said.is_significant, said.steps) == ("wrong-dwell", True, (step,))
        assert f"step {step}, replication {lost.replication}, point {lost.point} (pitch" in said.fact
        assert "with 850 °C; allowed −100 to 200 °C" in said.fact
        assert f"calrig void R9 --from {step} " in said.what_to_do
        assert said.text in axis.warnings
    assert found.calibration.verdict != "sound"


def test_the_range_of_a_set_and_its_air_have_no_such_temperature(measured: Measured) -> None:
    entry, dwells, run_dir = measured
    wild = with_reading(dwells, design_steps(dwells)[:1], 850.0)
    with JournalReader.open(run_dir) as reader:
        record = replace(read_record(reader), dwells=tuple(wild))
    stated = provenance_of(solved(entry, wild), record)
    assert stated.temperature_range_degc is not None
    assert stated.temperature_range_degc[1] < 40.0
    assert stated.environment["air"]["max_degc"] < 40.0


def test_many_are_a_thermometer_in_another_unit_and_are_refused(measured: Measured) -> None:
    entry, dwells, _ = measured
    steps = design_steps(dwells)
    for kelvin in (steps, steps[:5]):
        failure = solved(entry, with_reading(dwells, kelvin, 293.15)).failure
        assert "temperature_degc" in failure
        assert "allowed −100 to 200 °C" in failure


@pytest.mark.parametrize(("before", "after"), [(300.0, 20.0), (20.0, 300.0), (-200.0, 20.0)])
def test_one_of_two_readings_is_not_hidden_in_their_mean(before: float, after: float) -> None:
    looks = (Look({}, {"air": before}), Look({}, {"air": after}))
    (read,) = Measurement(*looks, {}, is_settled=True, settle_s=0.0).mean_temperature_degc().values()
    assert read == (before if abs(before) > 100.0 else after)
    mild = Measurement(Look({}, {"air": 20.0}), Look({}, {"air": 21.0}), {}, is_settled=True, settle_s=0.0)
    assert mild.mean_temperature_degc() == {"air": 20.5}


def test_a_long_rest_keeps_every_dwell_as_none_of_another_point_stands_beside(measured: Measured) -> None:
    entry, dwells, _ = measured
    steps = design_steps(dwells)
    wild = [dwell for dwell in with_reading(dwells, steps[:1], 850.0) if dwell.step in steps]
    resting = tuple(replace(dwell, point=1, motion=Rest(60.0)) for dwell in entry.plan.design_dwells)
    for plan, aside in ((entry.plan, 1), (replace(entry.plan, steps=resting), 0)):
        item = SensorRows("SN1", plan.sensors["SN1"], tuple(wild), entry.rig, plan, "run")
        assert len(without_wild_temperatures(item).item.dwells) == len(wild) - aside
