"""Whether a run goes on with the devices that it began with: an inertial unit that was set up anew is another one."""

from types import SimpleNamespace
from typing import cast

import pytest
from report_dwells import dwell, event
from stream_rig import vn100_rig

from procedures.journal.audit.known_devices import (
    dwells_by_device,
    known_devices,
    other_devices,
    replacements,
    tenures_in,
)
from procedures.plan.plan import Plan
from rig.twins.prologix import REAL_CLONE
from rig.wire import vn100 as wire

AS_RECORDED_BEFORE = "VectorNav VN-100T-CR, serial 100011981, firmware 2.1.0.0, no user compensation"
"""What journals say that were written before the other registers were read."""


def test_a_driver_that_tells_more_of_the_same_unit_is_no_other_device() -> None:
    found = vn100_rig().vn100().identify()
    assert other_devices({"imu": AS_RECORDED_BEFORE}, {"imu": found}) == {}
    assert other_devices({"imu": found}, {"imu": found}) == {}


@pytest.mark.parametrize("field", [0, 1])
@pytest.mark.parametrize("register", wire.SETUP)
def test_a_register_that_changes_while_a_run_rests_makes_it_another_device(register: int, field: int) -> None:
    rig = vn100_rig()
    before = {"imu": rig.vn100().identify()}
    content = list(rig.twin.setup[register])  # type: ignore[attr-defined]
    content[field] += 1.0
    rig.twin.setup[register] = tuple(content)  # type: ignore[attr-defined]
    after = {"imu": rig.vn100().identify()}
    for known, found in ((before, after), (after, before)):
        sentence = other_devices(known, found)["imu"]
        assert sentence.startswith("imu: was 'VectorNav")
        assert f"(register {register}: " in sentence


@pytest.mark.parametrize(
    ("stored", "found"),
    [
        (
            "HP3458A at address 22, revision 9,2, option 0, adjusted 247 times, HP3488A, 44470 in slot 1, by Prologix "
            "GPIB-USB Controller version 6.107",
            "HP3458A, revision 9,2, option 0, adjusted 247 times, HP3488A, 44470 in slot 1",
        ),
        (
            "lines of 5 columns at streams.logger at socket://127.0.0.1:35869; it cannot be asked who it is",
            "lines of 5 columns; it cannot be asked who it is",
        ),
        (
            "lines of 5 columns at twin of streams.logger; it cannot be asked who it is",
            "lines of 5 columns; it cannot be asked who it is",
        ),
        ("KEITHLEY 2000 7 A02, front inputs, VISA GPIB0 by @py, address 16", "KEITHLEY 2000 7 A02, front inputs"),
        (f"HP3458A at address 22, revision 9,2, HP3488A, by {REAL_CLONE}", "HP3458A, revision 9,2, HP3488A"),
        (f"HP3458A at address 22, revision 9,2, HP3488A, by Lab 2 ({REAL_CLONE})", "HP3458A, revision 9,2, HP3488A"),
        ("HP3458A at address 22, revision 9,2, HP3488A, by VISA GPIB0 by @py", "HP3458A, revision 9,2, HP3488A"),
        (f"KEITHLEY 2000 7 A02, front inputs, {REAL_CLONE}, address 16", "KEITHLEY 2000 7 A02, front inputs"),
    ],
)
def test_what_a_journal_of_before_has_of_the_way_to_a_device_is_none_of_it(stored: str, found: str) -> None:
    assert other_devices({"dmm": stored}, {"dmm": found}) == {}
    assert other_devices({"dmm": stored}, {"dmm": found.replace("2", "8", 1).replace("5 col", "6 col")}) != {}


@pytest.mark.parametrize(
    ("known", "found"),
    [
        ("ACME TT-1, serial 1234, address 3", "ACME TT-1, serial 9999, address 3"),
        ("ACME TT-1, serial 1234, address 3", "ACME TT-1, address 3"),
        ("ACME TT-1 at address 3", "ACME TT-1 at address 4"),
        ("ACME TT-1, by Smith", "ACME TT-1, by Jones"),
    ],
)
def test_what_a_driver_of_somebody_elses_says_is_compared_whole(known: str, found: str) -> None:
    assert set(other_devices({"axes.pitch": known}, {"axes.pitch": found})) == {"axes.pitch"}
    assert other_devices({"axes.pitch": known}, {"axes.pitch": known}) == {}


def test_a_run_that_an_earlier_calrig_let_go_on_with_another_device_keeps_its_first_and_tells_who_measured() -> None:
    """Its journal has the other one's answers behind the trip, at a resume that nobody answered for, and a dwell."""
    first, other = {"readouts.dmm": "A"}, {"readouts.dmm": "B"}
    measured = [dwell(1), dwell(2, epoch=3)]
    stamped = [
        event(1, "identities", 0, **first),
        event(2, "dwell", 1, step=1, attempt=1, epoch=1),
        event(3, "identities", 2, **other),
        event(4, "state", 2, to="tripped", cause="identity"),
        event(5, "identities", 3, **other),
        event(6, "dwell", 4, step=2, attempt=1, epoch=3),
    ]
    known = known_devices(stamped)
    assert (known.of_run, known.seen_last) == (first, other)
    plan = cast("Plan", SimpleNamespace(channels=("dmm.x",), attitude_reference=None))
    held = tenures_in(stamped, measured, plan)["readouts.dmm"]
    assert [(tenure.identity, tenure.steps, tenure.by) for tenure in held] == [("A", (1,), ""), ("B", (2,), "")]


def test_a_device_that_was_replaced_before_it_measured_is_still_the_runs_own_and_one_that_came_back_is_one() -> None:
    """What the rig file declares is of the first: its certificate stood behind every dwell of the one in its place."""
    first, other = {"readouts.dmm": "A"}, {"readouts.dmm": "B"}
    taken = {"by": "carla", "reason": "repair"}
    stamped = [
        event(1, "identities", 0, **first),
        event(2, "identities", 1, **other),
        event(3, "override", 1, devices=other, **taken),
        event(4, "dwell", 2, step=1, attempt=1, epoch=2),
        event(5, "identities", 3, **first),
        event(6, "override", 3, devices=first, **taken),
        event(7, "dwell", 4, step=2, attempt=1, epoch=3),
    ]
    plan = cast("Plan", SimpleNamespace(channels=("dmm.x",), attitude_reference=None))
    measured = [dwell(1, epoch=2), dwell(2, epoch=3)]
    until_b = tenures_in(stamped[:4], measured, plan)["readouts.dmm"]
    assert [(tenure.identity, tenure.steps, tenure.by) for tenure in until_b] == [("A", (), ""), ("B", (1,), "carla")]
    (told,) = replacements({"readouts.dmm": until_b})
    assert (
        "'A' measured no dwell that counts; then 'B', taken over by carla: repair, measured 1 dwell of step 1" in told
    )
    back = tenures_in(stamped, measured, plan)["readouts.dmm"]
    assert [tenure.identity for tenure in back] == ["A", "B", "A"]
    assert dwells_by_device(back) == {"A": 1, "B": 1}
