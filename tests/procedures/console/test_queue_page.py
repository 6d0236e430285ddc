"""The queue in a browser: what runs until when is armed by name, in view of what was seen, and not by everybody."""

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import pytest
from command import call
from hypothesis import given
from hypothesis import strategies as st
from queue_scene import Scene
from small_run import PROCEDURE, RIG
from starlette.testclient import TestClient
from visited_console import BASE, Visited

from procedures.console import queues
from procedures.queue import people
from procedures.queue.store import QueueStore
from procedures.records.states import State
from rig.description.read import read_rig
from rig.lines.lock import acquire
from rig.plain_text import hidden_in

OWN = {"origin": BASE}
QUEUE = "/api/v1/queues/bench"


@pytest.fixture
def visited(tmp_path: Path) -> Iterator[Visited]:
    found = Visited(tmp_path)
    yield found
    found.console.close()


@pytest.fixture
def scene(visited: Visited, tmp_path: Path) -> Scene:
    made = Scene(visited.console.queues / "bench", visited.clock)
    for name, text in (("procedure.toml", "[procedure]\n"), ("rig.toml", RIG)):
        (tmp_path / name).write_text(text)
    for title in ("first <b>night", "second"):
        people.add(
            made.store, tmp_path / "procedure.toml", tmp_path / "rig.toml", read_rig(tmp_path / "rig.toml"),
            tmp_path / "runs", "Anna", title=title, named_files=(), not_before_utc=None,
            not_after_utc=visited.clock.now_utc() + timedelta(hours=9), refused=[],
        )  # fmt: skip
    return made


def _post(visited: Visited, scene: Scene, browser: TestClient, act: str, **fields: str) -> tuple[int, str]:
    given = {"csrf": visited.csrf(browser), "expects": str(scene.queue().sequence), "key": act} | fields
    answer = browser.post(f"{QUEUE}/{act}", data=given, headers=OWN)
    return answer.status_code, answer.json()["told"]


def test_the_page_shows_what_waits_and_for_what(visited: Visited, scene: Scene) -> None:
    page = visited.enter().get("/queue").text
    assert "DISARMED" in page
    assert "nobody has armed it" in page
    assert "first &lt;b&gt;night" in page
    (queue,) = visited.browser.get("/api/v1/queues").json()["queues"]
    assert [entry["place"] for entry in queue["items"]] == ["waiting", "waiting"]


@pytest.mark.parametrize(
    ("mounted", "complaint"),
    [
        ("SN1=<b>\u202e", "holds <U+202E>, which nobody sees"),
        ("=A", "names no sensor"),
        ("SN1=A SN1=B", "names a sensor a second time"),
    ],
)
def test_what_is_attested_in_the_browser_is_looked_at_as_on_the_command_line(
    tmp_path: Path, visited: Visited, scene: Scene, capsys: pytest.CaptureFixture[str], mounted: str, complaint: str
) -> None:
    code, found = _post(visited, scene, visited.person("Ben", "move"), "attest", mounted=mounted)
    assert (code, complaint in found) == (409, True)
    outcome = call(capsys, "queue", "attest", *mounted.split(), "--rig", tmp_path / "rig.toml", "--operator", "Ben")
    assert (outcome.status, complaint in outcome.err) == (2, True)
    assert scene.queue().attestation is None


def _seen(text: str) -> bool:
    """Whether every letter is seen: a rig file holds no others, nor does what is attested."""
    return not hidden_in(text)


@given(
    st.dictionaries(
        st.text(st.characters(exclude_categories=["C", "Z"], exclude_characters="="), min_size=1).filter(_seen),
        st.text(st.characters(exclude_categories=["C", "Zl", "Zp"])).map(str.strip).filter(_seen),
        min_size=1,
    )
)
def test_what_the_page_offers_to_be_said_is_what_the_next_item_needs(needs: dict[str, str]) -> None:
    assert people.mounted_in(people.words_typed(people.typed_words(needs))) == needs


def test_a_datum_face_of_two_words_is_attested_in_the_browser(visited: Visited, scene: Scene) -> None:
    browser = visited.person("Ben", "move")
    code, found = _post(visited, scene, browser, "attest", mounted='SN1="face A, SN2')
    assert (code, "a quotation mark lacks its second" in found) == (409, True)
    assert _post(visited, scene, browser, "attest", mounted='SN1="face A", SN2=B SN3', key="again")[0] == 202
    said = scene.queue().attestation
    assert said is not None
    assert said.mounted == {"SN1": "face A", "SN2": "B", "SN3": ""}


def test_a_night_is_armed_and_decided_in_the_browser(visited: Visited, scene: Scene) -> None:
    browser = visited.person("Ben", "move")
    assert _post(visited, scene, browser, "attest", mounted="SN1")[0] == 202
    assert _post(visited, scene, browser, "move", number="2", to="1")[0] == 202
    assert _post(visited, scene, browser, "arm", until="23:00")[0] == 202
    armed = scene.queue()
    assert armed.arming is not None
    assert (armed.arming.by, [item.number for item in armed.items]) == ("Ben", [2, 1])
    assert "ARMED" in browser.get("/queue").text
    assert _post(visited, scene, browser, "remove", number="1")[0] == 202
    assert _post(visited, scene, browser, "disarm", expects="1")[0] == 202, "as it comes"
    code, found = _post(visited, scene, browser, "decide", number="2", choice="again", text="why")
    assert (code, "needed is needs a decision" in found) == (409, True)


@pytest.mark.parametrize("to", ["abc", "-1", "1.0", "²", "1" * 30, "7", "2"])
def test_an_item_is_put_before_another_that_is_there_or_nowhere(visited: Visited, scene: Scene, to: str) -> None:
    before = scene.queue()
    code, found = _post(visited, scene, visited.enter(), "move", number="2", to=to)
    assert code in (400, 409)
    assert "to put" in found
    assert "nothing was" in found
    assert scene.queue() == before


def test_a_run_that_the_queue_waits_for_is_decided_on_its_page(tmp_path: Path) -> None:
    """What ``calrig resume`` beside it would do, nobody on a phone can type, and the queue would go on waiting."""
    visited = Visited(tmp_path, State.STOPPED)
    made = Scene(visited.console.queues / "bench", visited.clock)
    for name, text in (("procedure.toml", "[procedure]\n"), ("rig.toml", RIG)):
        (tmp_path / name).write_text(text)
    rig = read_rig(tmp_path / "rig.toml")
    people.add(
        made.store, tmp_path / "procedure.toml", tmp_path / "rig.toml", rig, tmp_path / "runs", "Anna", title="first",
        named_files=(), not_before_utc=None, not_after_utc=None, refused=[],
    )  # fmt: skip
    browser = visited.enter()
    waits = "It is item 1 of the queue"
    changes = (
        ("start", {"item": 1, "boot": "b"}, False),
        ("began", {"item": 1, "run": str(visited.run)}, False),
        ("ended", {"item": 1, "state": "stopped", "reason": "looked at"}, True),
        ("decide", {"item": 1, "choice": "drop", "by": "Anna", "reason": "no"}, False),
    )
    for kind, detail, is_told in changes:
        made.store.change(lambda _, change=(kind, detail): change)  # type: ignore[misc]
        for path in ("/", "/night"):
            assert (waits in browser.get(path).text) == is_told, (kind, path)
    visited.console.close()


def test_who_may_not_or_has_not_seen_it_changes_nothing(visited: Visited, scene: Scene) -> None:
    operator, watcher = visited.person("Olga", "operate"), visited.person("Wim", "watch")
    before = scene.queue().sequence
    assert _post(visited, scene, operator, "arm", until="23:00")[0] == 403
    assert _post(visited, scene, watcher, "disarm")[0] == 403
    far = visited.person("Ben", "move", "192.0.2.9")
    code, found = _post(visited, scene, far, "arm", until="23:00")
    assert (code, "motion_from_elsewhere" in found) == (403, True)
    near = visited.enter()
    assert _post(visited, scene, near, "arm", until="23:00", expects="1")[0] == 409
    assert _post(visited, scene, near, "arm", key="x")[0] == 400
    assert _post(visited, scene, near, "arm", key="y", until="soon")[0] == 409
    assert near.post("/api/v1/queues/../../etc/arm", data={}, headers=OWN).status_code in (404, 405)
    assert scene.queue().sequence == before


class BeatenStore(QueueStore):
    """A store whose user is a moment too late: somebody else has put other work first since the page was looked at."""

    def change(self, decide):  # type: ignore[no-untyped-def]
        QueueStore(self.folder, self._clock).change(lambda queue: ("move", {"item": 2, "to": 1, "by": "Ben"}))
        return super().change(decide)


def test_what_was_seen_and_the_act_are_one(visited: Visited, scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, seen = visited.enter(), str(scene.queue().sequence)
    monkeypatch.setattr(queues, "QueueStore", BeatenStore)
    code, found = _post(visited, scene, browser, "arm", until="23:00", expects=seen)
    assert (code, "in view of another queue" in found) == (409, True)
    assert scene.queue().arming is None
    assert _post(visited, scene, browser, "arm", key="nothing seen", until="23:00", expects="")[0] == 409


def test_a_use_by_hand_is_shown_as_the_end_of_the_arming(visited: Visited, scene: Scene, tmp_path: Path) -> None:
    browser = visited.enter()
    assert _post(visited, scene, browser, "attest", mounted="SN1")[0] == 202
    assert _post(visited, scene, browser, "arm", until="23:00")[0] == 202
    with acquire([str(tmp_path / "rig.toml")], "run"):
        page = browser.get("/queue").text
        assert _post(visited, scene, browser, "arm", key="again", until="23:00")[0] == 409
    assert "DISARMED" in page
    assert "was used outside the queue, by process" in page
    assert "has had the rig, with what nobody has said" in page


@pytest.fixture
def files(visited: Visited, tmp_path: Path) -> Path:
    folder = visited.console.files
    folder.mkdir()
    (folder / "night.toml").write_text(PROCEDURE)
    (folder / "rig.toml").write_text(RIG)
    (tmp_path / "elsewhere.toml").write_text(PROCEDURE)
    (folder / "link.toml").symlink_to(tmp_path / "elsewhere.toml")
    return folder


def _add(visited: Visited, browser: TestClient, key: str, **fields: str) -> tuple[int, str]:
    given = {"csrf": visited.csrf(browser), "key": key, "procedure": "night.toml", "rig": "rig.toml"} | fields
    answer = browser.post("/api/v1/queues", data=given, headers=OWN)
    return answer.status_code, answer.json()["told"]


def test_a_run_is_added_by_the_page_as_the_command_adds_it(visited: Visited, files: Path) -> None:
    browser = visited.person("Olga", "operate")
    page = browser.get("/queue").text
    assert "<option>night.toml</option>" in page
    assert "link.toml" not in page
    assert _add(visited, browser, "one", not_before="22:00")[0] == 202
    assert _add(visited, browser, "one", not_before="22:00")[0] == 202, "the same key counts once"
    (queue,) = browser.get("/api/v1/queues").json()["queues"]
    (item,) = queue["items"]
    assert (item["place"], item["added_by"], queue["armed"]) == ("waiting", "Olga", False)
    assert item["not_before_utc"] is not None


def test_the_page_adds_only_files_that_it_offers_and_for_who_may(visited: Visited, files: Path) -> None:
    operator = visited.person("Olga", "operate")
    for number, name in enumerate(("link.toml", "../elsewhere.toml", "rig.toml", "", str(files / "night.toml"))):
        code, found = _add(visited, operator, f"bad {number}", procedure=name)
        assert (code, "allowed are night.toml" in found) == (400, True)
    code, found = _add(visited, operator, "late", not_after="soon")
    assert (code, "needed is a time" in found) == (409, True)
    assert _add(visited, visited.person("Wim", "watch"), "watch")[0] == 403
    assert _add(visited, operator, "token", csrf="another")[0] == 403
    (files / "night.toml").write_text(PROCEDURE.replace("replications", "replication"))
    code, found = _add(visited, operator, "wrong")
    assert (code, "night.toml" in found) == (409, True)
    assert operator.get("/api/v1/queues").json()["queues"] == []
