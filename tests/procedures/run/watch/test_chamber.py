"""A chamber in a run: what it heard wrongly is put right and on record, or trips with where its air is heading."""

from collections.abc import Iterator
from itertools import chain, repeat
from pathlib import Path

from faulty_rig import FaultyRig
from small_run import bench
from unattended_run import UnattendedRun, events, run_unattended

from procedures.records.states import State
from rig.devices.watlow_f4 import WatlowF4
from rig.errors import DeviceNonsense
from rig.twins.physics.world import World

PLATEAU = "[environment]\nplateaus_degc = [30.0]\nsoak_s = 60.0\n[check]"


def _mishearing(heard_degc: Iterator[float]) -> type[FaultyRig]:
    """Return a rig whose chamber hears, for as long as there is something to hear, other set points than are sent."""

    class Mishears(FaultyRig):
        has_begun = False

        @property
        def environments(self):  # type: ignore[no-untyped-def]
            chamber = self._rig.environments["air"]
            assert isinstance(chamber, WatlowF4)
            if not self.has_begun:
                self.has_begun, write = True, chamber.write_setpoint
                chamber.write_setpoint = lambda degc: write(next(heard_degc, degc))  # type: ignore[method-assign]
            return {"air": chamber}

    return Mishears


def test_a_set_point_that_was_heard_wrongly_once_is_put_right_and_on_record(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", PLATEAU),))
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=_mishearing(iter((80.0,))))
    assert outcome.state is State.FINISHED
    (noted,) = events(unattended.run_dir, "chamber")
    told = "air: set point 30 °C was written and reads back 80 °C; written once more"
    assert noted.detail == {"environment": "air", "told": told}


def test_one_that_stays_wrong_trips_and_the_page_sends_to_the_chamber(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", PLATEAU),))
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=_mishearing(chain(repeat(80.0, 2), repeat(79.0))))
    assert (outcome.state, outcome.cause) == (State.TRIPPED, "chamber")
    assert "air: the chamber is heading for 80 °C: set point 30 °C was written twice and reads back" in outcome.reason
    page = " ".join((unattended.run_dir / "why.txt").read_text(encoding="utf-8").split())
    assert "The chamber is not at work as calrig told it" in page
    assert "limit switch" not in page


def _alarming(alarms: Iterator[tuple[str, ...]]) -> type[FaultyRig]:
    """Return a rig whose chamber tells these alarms, one answer after the other, and then none any more."""

    class Alarms(FaultyRig):
        @property
        def environments(self):  # type: ignore[no-untyped-def]
            chamber = self._rig.environments["air"]
            chamber.alarms = lambda: next(alarms, ())
            return {"air": chamber}

    return Alarms


def test_an_alarm_that_leaves_the_air_in_its_band_is_told_when_it_comes_and_when_it_goes(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", PLATEAU),))
    unattended = UnattendedRun(tmp_path / "run")
    alarms = iter(((), ("alarm 1 (register 1356 reads 6)",), ("alarm 1 (register 1356 reads 6)",)))
    assert run_unattended(small, unattended, rig_of=_alarming(alarms)).state is State.FINISHED
    assert [event.detail["told"] for event in events(unattended.run_dir, "chamber")] == [
        "air: the chamber tells alarm 1 (register 1356 reads 6)",
        "air: the chamber tells no alarm any more",
    ]


def test_a_chamber_without_an_answer_is_told_once_and_keeps_no_run(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", PLATEAU),))
    unattended = UnattendedRun(tmp_path / "run")

    def unanswered() -> Iterator[tuple[str, ...]]:
        raise DeviceNonsense("ALARM? is not known to this chamber: NA:CMD ERR")
        yield ()

    assert run_unattended(small, unattended, rig_of=_alarming(unanswered())).state is State.FINISHED
    (noted,) = events(unattended.run_dir, "chamber")
    assert "air: the chamber does not tell its alarms, and is asked for them no more: ALARM? is" in str(noted.detail)


def test_a_hold_for_the_band_names_the_alarm(tmp_path: Path) -> None:
    """As an F4T whose alarm took its outputs: the air drifts, and the controller says why."""
    plateau = PLATEAU.replace("soak_s = 60.0", "soak_s = 60.0\nband_degc = 1.0")
    small = bench(tmp_path, procedure=(("[check]", plateau),))

    def drift(unattended: UnattendedRun) -> None:
        world = unattended.rig.chance
        assert isinstance(world, World)
        world.air["air"].hold(20.0, unattended.rig.clock.monotonic_s())

    unattended = UnattendedRun(tmp_path / "run", after={10: drift})
    rig_of = _alarming(repeat(("alarm 1 (register 1356 reads 6)",)))
    assert run_unattended(small, unattended, rig_of=rig_of).state is State.FINISHED
    (held,) = [event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"]
    assert str(held.detail["reason"]).endswith("band_degc); the chamber tells alarm 1 (register 1356 reads 6)")
