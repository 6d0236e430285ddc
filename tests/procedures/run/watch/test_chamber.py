"""A chamber in a run: what it heard wrongly is put right and on record, or trips with where its air is heading."""

from collections.abc import Iterator
from itertools import chain, repeat
from pathlib import Path

from faulty_rig import FaultyRig
from small_run import bench
from unattended_run import UnattendedRun, events, run_unattended

from procedures.records.states import State
from rig.devices.watlow_f4 import WatlowF4

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
