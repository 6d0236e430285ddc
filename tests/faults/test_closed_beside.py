"""Relays that are closed behind the driver's back while a campaign runs: by another program or a hand at the panel, by
commands that the line alters or loses, by replies that are another's. No dwell of the journal holds a mixture.
"""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from device_sets import SHORTER, device_set
from fault_scripts import Story, tell_of
from small_run import Bench, measured_in

from procedures.journal.journal_reader import JournalReader
from procedures.records.states import State
from rig.description.fault_plan import FaultPlan
from rig.twins.hp3488a import Hp3488aTwin

Altered = Callable[[bytes], bytes]
UNDISTURBED = FaultPlan.model_validate({"fault": {"never": {"line": "*", "kind": "drop", "nth": 10**9}}})
STRIKES = 6


def _before(command: bytes) -> Altered:
    """Return what another program makes of a message: its own command comes first."""
    return lambda message: command + b";" + message


HANDS: dict[str, Altered] = {
    "a sensor": _before(b"CLOSE 102"),
    "all sensors": _before(b"CLOSE 101,102,103"),
    "an unused channel": _before(b"CLOSE 107"),
    "with ours": lambda message: message.replace(b"CLOSE 103", b"CLOSE 103,101"),
    "in place of ours": lambda message: message.replace(b"OPEN", b"CLOSE"),
}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    bench = device_set("table-3458a", tmp_path_factory.mktemp("clean"), SHORTER)
    assert bench.run(bench.folder / "clean").state is State.FINISHED
    return bench


def _disturb(monkeypatch: pytest.MonkeyPatch, altered: Altered, every: int, most: int) -> list[bytes]:
    """Alter one in so many messages that the scanner hears; returns those that came of it, as they come."""
    listen, struck, heard = Hp3488aTwin.listen, [], [0]

    def disturbed(twin: Hp3488aTwin, message: bytes, now_s: float) -> float:
        heard[0] += 1
        changed = altered(message)
        if changed != message and heard[0] >= every * (1 + len(struck)) and len(struck) < most:
            struck.append(message := changed)
        return listen(twin, message, now_s)

    monkeypatch.setattr(Hp3488aTwin, "listen", disturbed)
    return struck


def _said(story: Story) -> str:
    with JournalReader.open(story.run_dir) as reader:
        return " ".join(str(event.detail) for event in reader.events())


@pytest.mark.parametrize("hand", HANDS)
def test_a_relay_closed_behind_the_driver_s_back_is_told_and_no_mixture_is_a_dwell(
    campaign: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hand: str
) -> None:
    struck = _disturb(monkeypatch, HANDS[hand], every=97, most=STRIKES)
    story = tell_of(campaign, tmp_path / "run", UNDISTURBED, most_resumes=STRIKES)
    assert len(struck) == STRIKES
    assert story.is_finished
    assert story.trips >= 2  # the others fell where every relay was opened next
    assert re.search(r"scanner channel 10[1237]: got closed, need open", _said(story))
    assert measured_in(story.run_dir) == measured_in(campaign.folder / "clean")


@pytest.mark.parametrize("rule", [{"kind": "drop"}, {"kind": "previous", "on": "reply"}], ids=["lost", "of-before"])
def test_commands_that_are_lost_and_replies_that_are_another_s_leave_no_mixture(
    campaign: Bench, tmp_path: Path, rule: dict[str, object]
) -> None:
    strikes = {"line": "readouts.dmm", "on": "question", "nth": tuple(range(200, 6000, 197)), **rule}
    plan = FaultPlan.model_validate({"fault": {"beside": strikes}})
    story = tell_of(campaign, tmp_path / "run", plan, most_resumes=40)
    assert len(story.happened) >= 5
    assert story.is_finished
    assert measured_in(story.run_dir) == measured_in(campaign.folder / "clean")


def test_a_relay_that_is_closed_again_and_again_stops_the_run_and_says_which(
    campaign: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _disturb(monkeypatch, HANDS["an unused channel"], every=1, most=10**6)
    story = tell_of(campaign, tmp_path / "run", UNDISTURBED, most_resumes=0)
    assert story.outcome is not None
    assert story.outcome.state is State.TRIPPED
    assert "scanner channel 107: got closed, need open" in _said(story)
    assert measured_in(story.run_dir) == {}
