"""What is armed starts what who armed it meant: nobody who may not arm it brings anything about, by whatever act."""

import shutil
from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path
from typing import get_args

import pytest
from queue_scene import ANNA, BEN, Scene, arm_queue, end_process
from small_run import PROCEDURE, RIG
from starlette.testclient import TestClient
from visited_console import BASE, Visited

from procedures.console import queues
from procedures.console.acting import new_key
from procedures.console.rights import BEGINS_MOTION, LETS_MOVE, Act
from procedures.journal.journal_reader import JournalReader
from procedures.queue import adding, people
from procedures.queue.state import ItemState
from procedures.queue.store import folder_of_rig
from procedures.records.states import State
from rig.description.read import read_rig

OWN, ELSEWHERE, OLGA = {"origin": BASE}, "192.0.2.9", "Olga"
ACTS: tuple[Act, ...] = get_args(Act)
ALLOWS = "[console]\nmotion_from_elsewhere = true\n"
VARIANTS: dict[str, list[dict[str, str]]] = {
    "add": [{"procedure": "night.toml", "rig": "rig.toml"}],
    "move": [{"number": "2", "to": "1"}, {"number": "1", "to": "0"}],
    "remove": [{"number": "1"}, {"number": "2"}],
    "attest": [{"mounted": "SN1"}],
    "decide": [{"number": "1", "choice": choice, "text": "why"} for choice in ("again", "resume", "drop")],
    "arm": [{"until": "2099-01-01T06:00"}],
    "void": [{"number": "1", "text": "why", "remounted": "1"}, {"number": "1", "text": "why"}],
    "redo": [{"number": "1", "text": "why"}],
    "note": [{"text": "looked at"}],
}
Start = tuple[int, str]


@pytest.fixture
def visited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Visited]:
    monkeypatch.setattr(adding, "checked", lambda *_: [])
    monkeypatch.setattr(queues, "boot", lambda: "boot 1")  # as the runner of the scene has it
    found = Visited(tmp_path, State.STOPPED)
    found.console.files.mkdir()
    (found.console.files / "night.toml").write_text(PROCEDURE)
    (found.console.files / "rig.toml").write_text(RIG)
    yield found
    found.console.close()


class _Night:
    """The queue of the rig, made anew and armed, and what its runner makes of it."""

    def __init__(self, visited: Visited, rig: str = RIG) -> None:
        self.visited, self.files = visited, visited.console.files
        (self.files / "rig.toml").write_text(rig)
        folder = folder_of_rig(visited.console.queues, read_rig(self.files / "rig.toml").rig.name)
        shutil.rmtree(folder, ignore_errors=True)
        self.scene = Scene(folder, visited.clock)

    def add(self, not_before_h: float | None = None) -> None:
        rig_file, now = self.files / "rig.toml", self.visited.clock.now_utc()
        people.add(
            self.scene.store, self.files / "night.toml", rig_file, read_rig(rig_file), self.visited.run.parent, ANNA,
            title="a night", named_files=(), not_after_utc=None, refused=[],
            not_before_utc=None if not_before_h is None else now + timedelta(hours=not_before_h),
        )  # fmt: skip

    def made(self, kind: str, armed_by: str) -> "_Night":
        """Two items of which nothing starts at once, for the reason of the kind."""
        self.add(not_before_h=3.0 if kind == "early" else None)
        self.add()
        if kind != "unattested":
            people.attest(self.scene.store, ANNA, {"SN1": "" if kind in ("early", "at work") else "B"})
        arm_queue(self.scene, armed_by)
        if kind == "at work":  # and the next one needs what is not mounted then
            self.scene.step()
            assert self.scene.world.started == [(1, "start")]
            people.attest(self.scene.store, ANNA, {"SN9": ""})
        return self

    def post(self, browser: TestClient, act: str, **fields: str) -> tuple[int, str]:
        path = f"/api/v1/queues/{self.scene.folder.name}/{act}"
        if act == "add":
            path = "/api/v1/queues"
        if act in ("pause", "continue", "stop", "abort", "note", "ack", "void", "redo"):
            path = f"/api/v1/runs/night-1/{act}"
        if act in ("halt", "jog"):
            path = "/api/v1/jog/rig.toml/stop"
        expects = self.visited.expects() if "runs" in path else self.scene.queue().sequence
        given = {"csrf": self.visited.csrf(browser), "expects": str(expects), "key": new_key()} | fields
        answer = browser.post(path, data=given, headers=OWN)
        return answer.status_code, answer.json()["told"]

    def starts(self) -> dict[Start, float]:
        """Let six hours pass, in which every run finishes; hours to each start."""
        found: dict[Start, float] = {}
        for step in range(36):
            self.scene.step()
            for start in self.scene.world.started:
                found.setdefault(start, step / 6.0)
            if step % 2:
                for number in self.scene.world.alive():
                    end_process(self.scene, number, State.FINISHED)
            self.visited.clock.sleep(600.0)
        return found


@pytest.mark.parametrize("armed_by", [OLGA, pytest.param(ANNA, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("kind", ["unattested", "wrongly mounted", "early", "at work"])
def test_no_act_from_elsewhere_by_who_operates_brings_a_motion_about(
    visited: Visited, kind: str, armed_by: str
) -> None:
    """The law over every act that there is: what starts after it would have started without it, and no later.

    Olga operates; that the queue was armed in her name makes her no other at another machine.
    """
    expected = _Night(visited, RIG + ALLOWS).made(kind, armed_by).starts()
    secret = visited.people.add(OLGA, "operate", visited.clock.now_utc())
    for act, fields in [(known, given) for known in ACTS for given in VARIANTS.get(known, [{}])]:
        browser = visited.new_browser(ELSEWHERE)
        assert browser.post("/login", data={"name": OLGA, "secret": secret}, headers=OWN).status_code == 303
        token = browser.cookies["calrig"]
        assert visited.sessions.tell_code(token, visited.sessions.new_code()), "the code makes nobody one who may arm"
        night = _Night(visited, RIG + ALLOWS).made(kind, armed_by)
        code, found = night.post(browser, act, **fields)
        if act in BEGINS_MOTION and act not in ("jog", "continue"):
            assert (code, "needs the role move" in found) == (403, True), act
        started = night.starts()
        for start, hours in started.items():
            assert start in expected, f"{act} {fields}: {start} began by it: {found}"
            assert hours >= expected[start], f"{act} {fields}: {start} began sooner by it: {found}"


@pytest.mark.parametrize(("act", "fields"), [(act, VARIANTS[act][0]) for act in ("add", "move", "remove", "attest")])
def test_who_may_not_arm_disarms_and_is_told_so(visited: Visited, act: str, fields: dict[str, str]) -> None:
    for name, browser in ((OLGA, visited.person(OLGA, "operate")), (BEN, visited.person(BEN, "move", ELSEWHERE))):
        night = _Night(visited).made("unattested", name)
        page = browser.get("/queue").text
        assert "What you move, remove, add or attest disarms it" in page
        code, found = night.post(browser, act, **fields)
        assert code == 202, found
        queue = night.scene.queue()
        assert queue.arming is None
        assert queue.disarmed_because.endswith("by a role or from a place that may not arm it")
        assert act == "add" or "the queue is disarmed by it" in found


def test_who_may_begin_motion_from_elsewhere_attests_what_was_armed(visited: Visited) -> None:
    """With the role, the code, and a rig file that allows it; each of the three alone is too little."""
    browser = visited.person(BEN, "move", ELSEWHERE)
    for rig, has_code, stays in ((RIG + ALLOWS, False, False), (RIG, True, False), (RIG + ALLOWS, True, True)):
        if has_code:
            assert visited.sessions.tell_code(browser.cookies["calrig"], visited.sessions.new_code())
        night = _Night(visited, rig).made("unattested", ANNA)
        assert night.post(browser, "attest", mounted="SN1")[0] == 202
        night.scene.step()
        assert (night.scene.queue().arming is not None, bool(night.scene.world.started)) == (stays, stays)


def test_what_is_taken_back_by_who_may_not_arm_disarms_the_queue_of_that_rig(visited: Visited) -> None:
    """A run that an armed queue is about to resume would measure them again."""
    night = _Night(visited).made("unattested", ANNA)
    with JournalReader.open(visited.run) as reader:
        of_run = reader.header.rig_path
    for browser, stays in ((visited.enter(), True), (visited.person(OLGA, "operate", ELSEWHERE), False)):
        night.scene.store.change(lambda queue: ("add", _added_again(night.scene, of_run, queue.numbers + 1)))
        arm_queue(night.scene)
        _, found = night.post(browser, "void", number="1", text="leaned on", key=str(stays))
        assert ("it is disarmed by this" in found) != stays
        assert (night.scene.queue().arming is not None) == stays, found


def _added_again(scene: Scene, rig_path: str, number: int) -> dict[str, object]:
    """The last item once more, as one of a rig file at another place."""
    before = dict(next(event.detail for event in scene.queue().events if event.kind == "add"))
    return {**before, "item": number, "rig": {**before["rig"], "path": rig_path}}


def test_every_act_begins_motion_lets_some_begin_or_does_neither() -> None:
    """Whoever adds an act says here which of the three it is."""
    neither = {"pause", "stop", "abort", "note", "ack", "disarm", "halt"}
    assert set(ACTS) == {*BEGINS_MOTION, *LETS_MOVE, *neither}
    assert len(ACTS) == len(BEGINS_MOTION) + len(LETS_MOVE) + len(neither)


def test_another_person_who_takes_an_item_out_disarms(visited: Visited) -> None:
    for by in (ANNA, BEN):
        night = _Night(visited).made("early", ANNA)
        people.remove(night.scene.store, 1, by)
        assert (night.scene.queue().arming is not None) == (by == ANNA)
        assert bool(night.starts()) == (by == ANNA)
        assert next(item.state for item in night.scene.queue().items) is ItemState.REMOVED
