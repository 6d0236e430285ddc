"""Messages get out where no thread can be had: by one that began before, or by whoever waits for them in the end."""

import errno
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
from journals import a_clock

from procedures.alerts.channels import Message, NotDelivered, by_command
from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.outbox import HEARTBEAT, Outbox
from procedures.alerts.settings import AlertSettings
from procedures.records.progress import Progress, SilentObserver
from procedures.records.states import State
from rig.clock import VirtualClock

HOLD = Progress("state", State.HELD, 3, 24, 1, 2, None, None, "environment.air: got 25 °C, allowed 18 to 22 °C")
PATIENCE_S = 60.0
WRITES = "import sys; open(sys.argv[1], 'w').write(sys.stdin.read())"


@pytest.fixture
def clock() -> VirtualClock:
    return a_clock()


def _dispatcher(clock: VirtualClock, heard: Path) -> AlertDispatcher:
    settings = AlertSettings(command=(sys.executable, "-c", WRITES, str(heard)))
    return AlertDispatcher(settings, "night", clock, SilentObserver())


def _no_thread(*_: object) -> int:
    raise RuntimeError("can't start new thread")


def test_a_hold_for_which_no_thread_can_be_had_is_told_by_one_that_began_before(
    clock: VirtualClock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the run waits, and nobody else has time to deliver anything."""
    dispatcher = _dispatcher(clock, tmp_path / "told.txt")
    dispatcher.stand_by()
    monkeypatch.setattr("rig.threads.start_new_thread", _no_thread)
    dispatcher.on_event(HOLD)
    dispatcher._outbox.join(lambda: PATIENCE_S)
    assert dispatcher.pulse() == [{"what": "calrig: night: held", "failed": ""}]
    assert (tmp_path / "told.txt").read_text().startswith("calrig: night: held\n")
    dispatcher.close()


def test_an_end_for_which_no_thread_can_be_had_is_told_by_whoever_waits_for_it(
    clock: VirtualClock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.threads.start_new_thread", _no_thread)
    dispatcher = _dispatcher(clock, tmp_path / "told.txt")
    dispatcher.tell_end("finished", "usable")
    assert dispatcher.pulse() == []
    assert dispatcher.close() == [{"what": "calrig: night: finished", "failed": ""}]
    assert dispatcher.close() == [], "once"


def test_what_no_thread_takes_is_delivered_within_the_deadline_and_the_rest_is_said_to_be_lost(
    clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.threads.start_new_thread", _no_thread)
    monkeypatch.setattr("procedures.alerts.dispatcher.by_command", lambda *_: clock.sleep(31.0))
    dispatcher = AlertDispatcher(AlertSettings(command=("x",), deadline_s=30.0), "night", clock, SilentObserver())
    for word in ("one", "two"):
        dispatcher.tell_end(word, "")
    first, second = dispatcher.close()
    assert first == {"what": "calrig: night: two", "failed": ""}, "the newest: it says where the run stands"
    assert second["what"] == "calrig: night: one"
    assert "no thread could be begun for it" in str(second["failed"])


def test_a_heartbeat_that_hangs_takes_no_message_its_time(clock: VirtualClock, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is the newest, since it is sent at every look."""
    monkeypatch.setattr("rig.threads.start_new_thread", _no_thread)
    delivered: list[str] = []
    outbox = Outbox(clock, 30.0, ())
    outbox.send("tripped", lambda: delivered.append("tripped"))
    outbox.send(HEARTBEAT, lambda: clock.sleep(31.0))
    outbox.deliver_here()
    assert delivered == ["tripped"]


def test_an_old_message_that_hangs_does_not_keep_back_the_trip(
    clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.threads.start_new_thread", _no_thread)
    delivered_s: dict[str, float] = {}
    outbox, begun_s = Outbox(clock, 30.0, ()), clock.monotonic_s()
    outbox.send("a finding", lambda: clock.sleep(31.0))
    outbox.send("tripped", lambda: delivered_s.update(tripped=clock.monotonic_s() - begun_s))
    outbox.deliver_here()
    assert delivered_s["tripped"] < 1.0


@pytest.mark.parametrize(("refusals", "failure"), [(1, ""), (1000, "Resource temporarily unavailable")])
def test_a_command_for_which_the_system_has_no_room_is_tried_until_its_deadline(
    monkeypatch: pytest.MonkeyPatch, refusals: int, failure: str
) -> None:
    run, refused = subprocess.run, iter([True] * refusals)

    def crowded(*arguments: object, **options: object) -> object:
        if next(refused, False):
            raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
        return run(*arguments, **options)  # type: ignore[call-overload]

    monkeypatch.setattr(subprocess, "run", crowded)
    monkeypatch.setattr("procedures.alerts.channels.AGAIN_S", 0.01)
    with pytest.raises(NotDelivered, match=failure) if failure else nullcontext():
        by_command([sys.executable, "-c", ""], Message("held", "warm"), 0.2 if failure else PATIENCE_S)
