"""A device that was replaced is told of by the set of every sensor whose numbers rest on it, and by no other."""

from dataclasses import replace
from pathlib import Path

from small_run import bench, dwells_of

from ams.sets.coefficients import build_set
from ams.sets.equipment import equipment_of
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_sensors
from procedures.records.states import State
from procedures.solution.provenance import provenance_of
from procedures.solution.record import read_record
from rig.description.rig_file import AttitudeReference
from rig.description.sensor import SensorTemperature
from rig.description.signal_chain import Chain

REST_ON = {
    "readouts.dmm": "outputs",
    "readouts.thermo": "temperature",
    "readouts.volts": "supply",
    "streams.level": "attitude",
}


def test_thermometer_supply_and_reference_of_attitude_are_told_as_the_meter_of_the_outputs_is(tmp_path: Path) -> None:
    entry = bench(tmp_path)
    assert entry.run(tmp_path / "run").state is State.FINISHED
    solved = solve_sensors(dwells_of(tmp_path / "run"), entry.rig, entry.plan, "run")["SN1"]
    with JournalReader.open(tmp_path / "run") as reader:
        record = read_record(reader)
    thermometer = SensorTemperature.model_validate(
        {"channel": "thermo.t", "offset_degc": 0.0, "slope_degc_per_v": 100.0}
    )
    sensor = record.plan.sensors["SN1"].model_copy(update={"temperature": thermometer})
    reference = AttitudeReference(channels={"pitch": "level.tilt"}, uncertainty_deg=0.001)
    plan = replace(record.plan, sensors={"SN1": sensor}, attitude_reference=reference)
    chain = Chain.model_validate({"supply_channel": "volts.s", "supply_nominal_v": 5.0})
    rig = record.rig.model_copy(update={"chain": {"dmm.x": chain}})

    (asked,) = [event for event in record.events if event.kind == "identities"]
    names = (*REST_ON, "readouts.elsewhere")
    (middle,) = [n for n, event in enumerate(record.events) if event.kind == "dwell" and event.detail["step"] == 10]
    others = replace(asked, detail=dict.fromkeys(names, "B"))
    events = [replace(asked, detail=dict.fromkeys(names, "A")), *record.events[:middle], others]
    rest = [event for event in record.events[middle:] if event.kind != "identities"]
    record = replace(record, plan=plan, rig=rig, events=[event for event in events if event is not asked] + rest)

    provenance = provenance_of(solved, record)
    assert provenance.replaced_devices is not None
    assert {it["device"]: it["used_for"] for it in provenance.replaced_devices} == {
        name: [what] for name, what in REST_ON.items()
    }
    assert solved.calibration is not None
    equipment = equipment_of(build_set(solved.calibration, provenance))
    (meter,) = [row for row in equipment if row.name == "dmm"]
    later = sum(dwell.accepted and dwell.purpose == "design" and dwell.step >= 10 for dwell in record.dwells)
    assert f"but for {later} dwells that another device measured" in meter.used_for
    rows = [row for row in equipment if row.identity == "B"]
    assert [row.used_for.partition(" (")[0] for row in rows] == list(REST_ON.values())
