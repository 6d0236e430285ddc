"""Laws of the lease of a device that more computers reach: one has it, a loss is told, nothing ever stops a run.

Another computer is a process with a folder of locks of its own: nothing but the database keeps the two apart.
"""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from archive_kinds import Archive
from command import call
from small_run import RIG, bench
from turning_rig import served
from unattended_run import UnattendedRun, events, run_unattended

from ams.archive.leases import CLOCKS_APART_S, held
from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings
from procedures.lease.keeper import LAPSES_S, LeaseKeeper, LeaseNews, leased
from procedures.records.progress import LEASE, LEASE_LOST, Progress, SilentObserver
from procedures.records.states import State
from procedures.run.handover import handover
from procedures.run.preflight import preflight
from procedures.run.services import RunServices
from rig.clock import SystemClock, VirtualClock
from rig.description.read import read_rig
from rig.errors import RigBusy

NOON_UTC = datetime(2026, 3, 1, 12, tzinfo=UTC)
DEVICE = "tcp 192.0.2.7 1234"
NEVER_S = 3600.0
CLOCK = SystemClock()
HOLDER = """
import sys
from procedures.lease.keeper import leased
with leased(sys.argv[1], "run night", print, lapses_s=float(sys.argv[2]), renewed_s=0.1) as lease:
    lease.claim(sys.argv[3:])
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[str], None]:
    """Make this process, and those that it begins, another computer's."""
    return lambda name: monkeypatch.setenv("CALRIG_MACHINE_FOLDER", str(tmp_path / name))


@contextmanager
def _holder(url: str, lapses_s: float, *resources: str) -> Iterator["subprocess.Popen[str]"]:
    """A process that has the lease, and gives it back when its input ends."""
    command = [sys.executable, "-c", HOLDER, url, str(lapses_s), *resources]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        try:
            yield process
        finally:
            process.kill()


class _Wall(VirtualClock):
    """Time that passes when it is told to; nobody waits for it."""

    def __init__(self) -> None:
        super().__init__(datetime.now(UTC))


def _keeper(archive: Archive, clock: _Wall, expected: list[str]) -> LeaseKeeper:
    keeper = LeaseKeeper(archive.url, "run night", expected.append, clock, LAPSES_S, NEVER_S)
    keeper.claim([DEVICE])
    return keeper


def test_fault_80_another_computer_is_refused_and_told_who_has_it_until_it_is_given_back(
    archive: Archive, elsewhere: Callable[[str], None]
) -> None:
    elsewhere("lab1")
    with _holder(archive.url, LAPSES_S, DEVICE) as other:
        elsewhere("lab2")
        with leased(archive.url, "jog", pytest.fail) as lease, pytest.raises(RigBusy) as refused:
            lease.claim([DEVICE])
        sentence = str(refused.value)
        assert sentence.startswith("192.0.2.7 port 1234: another computer has it: ")
        assert "(run night), since " in sentence
        assert " s if nothing more is heard of it; nothing was opened; wait until it has finished" in sentence
        other.communicate("")
        assert other.returncode == 0
        with leased(archive.url, "jog", pytest.fail) as lease:
            lease.claim([DEVICE])
            assert [entry.holder.purpose for entry in held(archive.url, [DEVICE], CLOCK.now_utc())] == ["jog"]
        assert held(archive.url, [DEVICE], CLOCK.now_utc()) == ()


@pytest.mark.thorough
def test_the_lease_of_a_killed_process_lapses_and_its_own_computer_need_not_wait(
    archive: Archive, elsewhere: Callable[[str], None]
) -> None:
    elsewhere("lab1")
    with _holder(archive.url, 1.0, DEVICE) as other:
        other.kill()
        other.wait()
    with leased(archive.url, "resume", pytest.fail) as lease:
        lease.claim([DEVICE])
    with _holder(archive.url, 1.0, DEVICE) as other:
        other.kill()
        other.wait()
    elsewhere("lab2")
    late = _Wall()
    with leased(archive.url, "jog", pytest.fail, late) as lease:
        with pytest.raises(RigBusy, match="lapses in"):
            lease.claim([DEVICE])
        if archive.url.startswith("sqlite"):
            late.sleep(CLOCKS_APART_S + 1.0)
        while held(archive.url, [DEVICE], late.now_utc()):
            CLOCK.sleep(0.05)  # a server has a clock of its own
        lease.claim([DEVICE])


def test_a_database_that_is_lost_is_an_alarm_once_and_found_again(archive: Archive) -> None:
    clock, messages = _Wall(), list[str]()
    keeper = _keeper(archive, clock, messages)
    assert keeper.news() == []
    archive.execute("ALTER TABLE leases RENAME TO away")
    clock.sleep(LAPSES_S - 1.0)
    keeper.renew()
    assert keeper.news() == [], "a lease that has not lapsed is not lost"
    clock.sleep(1.0)
    (news,) = keeper.news()
    assert news.is_lost
    assert news.text.startswith(
        "the lease of 192.0.2.7 port 1234 has lapsed: the archive could not be asked for 120 s ("
    )
    assert news.text.endswith("; another computer may take the device; the run goes on")
    clock.sleep(LAPSES_S)
    assert keeper.news() == []
    archive.execute("ALTER TABLE away RENAME TO leases")
    keeper.renew()
    assert keeper.news() == [LeaseNews("the lease of 192.0.2.7 port 1234 is held again", is_lost=False)]
    keeper.close()
    assert held(archive.url, [DEVICE], clock.now_utc()) == ()
    assert messages == []


@pytest.mark.thorough
def test_a_lease_that_another_took_is_an_alarm_until_it_is_free(
    archive: Archive, elsewhere: Callable[[str], None]
) -> None:
    elsewhere("lab1")
    clock = _Wall()
    keeper = _keeper(archive, clock, [])
    archive.execute("DELETE FROM leases")
    elsewhere("lab2")
    with _holder(archive.url, LAPSES_S, DEVICE) as other:
        keeper.renew()
        (news,) = keeper.news()
        assert news.is_lost
        assert news.text.startswith("192.0.2.7 port 1234: the lease is lost: another computer has it: ")
        assert keeper.news() == []
        other.communicate("")
    keeper.renew()
    assert [news.is_lost for news in keeper.news()] == [False]
    archive.execute("DELETE FROM leases")
    keeper.renew()
    texts = [(news.text, news.is_lost) for news in keeper.news()]
    assert texts[0] == (
        "the lease of 192.0.2.7 port 1234 had lapsed and was not kept: another computer may have had the device; the run goes on",  # noqa: E501
        True,
    )
    assert texts[1][1] is False
    keeper.close()


def test_a_database_that_does_not_answer_refuses_nothing_and_says_that_nothing_guards(tmp_path: Path) -> None:
    clock, messages = _Wall(), list[str]()
    keeper = _keeper(Archive(f"sqlite:///{tmp_path / 'away' / 'archive.sqlite'}"), clock, messages)
    assert "192.0.2.7 port 1234: nothing guards against a second computer now: " in messages[0]
    (news,) = keeper.news()
    assert news.is_lost
    assert news.text.startswith("no lease of 192.0.2.7 port 1234 could be taken (")
    (tmp_path / "away").mkdir()
    keeper.renew()
    assert [news.is_lost for news in keeper.news()] == [False]
    keeper.close()


def test_a_share_that_is_gone_is_not_made_anew(tmp_path: Path) -> None:
    """Its folder is there and empty: a second computer would find nothing taken in a file of its own."""
    clock, file = _Wall(), tmp_path / "archive.sqlite"
    keeper = _keeper(Archive(f"sqlite:///{file}"), clock, [])
    file.rename(tmp_path / "away")
    clock.sleep(LAPSES_S)
    keeper.renew()
    (news,) = keeper.news()
    assert "there is no archive: no such file" in news.text
    assert not file.exists()
    (tmp_path / "away").rename(file)
    keeper.close()


def test_fault_80_a_run_whose_lease_is_lost_rings_and_goes_on_to_its_end(tmp_path: Path) -> None:
    """Detected: the database does not renew the lease, or says that another has it.
    Response: an alarm in the journal and to people; the run measures on.
    """
    small, unattended = bench(tmp_path), UnattendedRun(tmp_path / "run")
    lost = LeaseNews("the lease of 192.0.2.7 port 1234 has lapsed: …; the run goes on", is_lost=True)
    again = LeaseNews("the lease of 192.0.2.7 port 1234 is held again", is_lost=False)
    due = {3: lost, 9: again}

    def news() -> list[LeaseNews]:
        done = max((progress.dwells_done for progress in unattended.heard), default=0)
        return [due.pop(at) for at in sorted(due) if at <= done]

    outcome = run_unattended(small, unattended, RunServices(lease_news=news))
    assert outcome.state is State.FINISHED
    assert [event.detail["lost"] for event in events(unattended.run_dir, "lease")] == [True, False]
    assert [progress.event for progress in unattended.heard if progress.event in (LEASE, LEASE_LOST)] == [
        LEASE_LOST,
        LEASE,
    ]
    assert "the lease of 192.0.2.7 port 1234 has lapsed" in handover(unattended.run_dir)


def test_a_lost_lease_is_told_again_until_it_is_acknowledged_or_over(tmp_path: Path) -> None:
    clock, file = VirtualClock(datetime(2026, 3, 1, tzinfo=UTC)), tmp_path / "told.jsonl"
    write = "import json, pathlib, sys; pathlib.Path(sys.argv[1]).open('a').write(json.dumps(sys.stdin.read()) + '\\n')"
    settings = AlertSettings(command=(sys.executable, "-c", write, str(file)), repeat_every_s=900.0)
    dispatcher = AlertDispatcher(settings, "night", clock, SilentObserver())
    lost = Progress(LEASE_LOST, State.RUNNING, 3, 24, 1, 2, None, None, "the lease of X has lapsed; the run goes on")

    def subjects() -> list[str]:
        dispatcher.close()
        texts = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
        file.write_text("", encoding="utf-8")
        return [text.splitlines()[0] for text in texts]

    dispatcher.on_event(lost)
    assert subjects() == ["calrig: night: the lease of a device is lost"]
    dispatcher.on_event(replace(lost, event="state", state=State.PAUSED, requested_by="anna", message=""))
    clock.sleep(900.0)
    dispatcher.pulse()
    assert subjects() == ["calrig: night: still without its lease"]
    dispatcher.on_event(replace(lost, event=LEASE, message="the lease of X is held again"))
    clock.sleep(900.0)
    dispatcher.pulse()
    assert subjects() == ["calrig: night: the lease of a device is held again"]


def test_fault_80_a_jog_from_a_second_computer_is_refused_but_never_its_stop(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    elsewhere: Callable[[str], None],
) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    monkeypatch.setattr("rig.lines.lock.address_of", lambda _host: "192.0.2.7")  # a name that other computers know too
    with served(tmp_path, SystemClock()) as (simulated, path):
        ports = sorted({address.rpartition(":")[2] for address in simulated.addresses.values()})
        elsewhere("lab1")
        with _holder(url, LAPSES_S, *(f"tcp 192.0.2.7 {port}" for port in ports)):
            elsewhere("lab2")
            monkeypatch.setenv("CALRIG_ARCHIVE", url)
            refused = call(capsys, "jog", "--rig", path, "--axis", "pitch", "--home")
            assert refused.status != 0
            assert "another computer has it: " in refused.err
            assert "nothing was opened" in refused.err
            found = preflight(path, read_rig(path), None, tmp_path, NOON_UTC, archive_url=url)
            assert all("another computer has it" in sentence for sentence in found.refusals)
            assert (len(found.refusals) >= 2, found.unguarded) == (True, ())
            stopped = call(capsys, "jog", "--rig", path, "--stop", "--axis", "pitch")
            assert stopped.status == 0, stopped.err


def test_check_says_what_guards_and_what_does_not(tmp_path: Path) -> None:
    text = RIG.partition("[twin]")[0].replace('resource = "twin"', 'resource = "prologix+socket://192.0.2.7:1234#22"')
    path = tmp_path / "rig.toml"
    text = text.replace('driver = "watlow-f4"\nport = "twin"', 'driver = "watlow-f4"\nport = "socket://localhost:2"')
    path.write_text(text.replace('port = "twin"', 'port = "socket://localhost:1"'))

    def looked(url: str | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
        found = preflight(path, read_rig(path), None, tmp_path / "runs", NOON_UTC, archive_url=url)
        return found.guarded, found.unguarded

    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    (guarded,), unguarded = looked(url)
    assert unguarded == ()
    assert guarded == f"192.0.2.7 port 1234: guarded by a lease in {url} against computers that use the same archive"
    assert not (tmp_path / "archive.sqlite").exists(), "to look makes nothing"
    (tmp_path / "archive.sqlite").write_text("no database at all, and longer than a header of one would be: " * 4)
    guarded, (sentence,) = looked(url)
    assert guarded == ()
    assert sentence.startswith("192.0.2.7 port 1234: nothing guards against a second computer now: ")
    assert looked(None)[0] == ()


def test_a_lease_that_no_thread_would_keep_is_refused_and_not_left_behind(
    archive: Archive, elsewhere: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would lapse while its holder moves the device, and another computer would move it too."""

    def refused(*_: object) -> int:
        raise RuntimeError("can't start new thread")

    elsewhere("lab1")
    with monkeypatch.context() as patched, leased(archive.url, "jog", pytest.fail) as lease:
        patched.setattr("rig.threads.start_new_thread", refused)
        with pytest.raises(MemoryError, match=r"for the lease of 192\.0\.2\.7 port 1234, which nobody would keep"):
            lease.claim([DEVICE])
    assert held(archive.url, [DEVICE], CLOCK.now_utc()) == ()


def test_a_keeper_that_has_no_memory_left_asks_again_and_says_that_the_lease_lapsed(
    archive: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    def starved(*_: object, **__: object) -> None:
        raise MemoryError

    clock, expected = _Wall(), list[str]()
    keeper = _keeper(archive, clock, expected)
    with monkeypatch.context() as patched:
        patched.setattr("procedures.lease.keeper.claim", starved)
        keeper.renew()
        clock.sleep(LAPSES_S)
        (lapsed,) = keeper.news()
    assert lapsed.is_lost
    assert "(no memory is left to ask it)" in lapsed.text
    keeper.renew()
    assert [news.is_lost for news in keeper.news()][-1:] == [False]
    keeper.close()
    assert not expected
