"""What a button does: the request of the command with the name of who pressed it, and nothing for whoever may not."""

import asyncio
import json
from collections.abc import Callable, Iterator
from html import unescape
from pathlib import Path

import pytest
from run_folders import make_run
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.testclient import TestClient, WebSocketTestSession
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect
from visited_console import BASE, CHEAP, Visited

from procedures.accounts.people import People
from procedures.cli.main import run_command
from procedures.console import acts, gate
from procedures.console.gate import LONGEST_BODY
from procedures.console.sessions import ACTS, LIFE_S, MOST_WRONG_SECRETS
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import add_note
from procedures.journal.sidecar.owner import owning
from procedures.records.states import State
from rig.plain_text import PARAGRAPHS, one_line, text_complaint

RUN = "/api/v1/runs/night-1"
OWN = {"origin": BASE}
ELSEWHERE = "192.0.2.9"


@pytest.fixture
def alive(tmp_path: Path) -> Iterator[Visited]:
    """A paused run that a process owns."""
    found = Visited(tmp_path, State.PAUSED)
    with owning(found.run):
        yield found
    found.console.close()


@pytest.fixture
def ended(tmp_path: Path) -> Iterator[Visited]:
    found = Visited(tmp_path, State.STOPPED)
    yield found
    found.console.close()


def _last(visited: Visited, kind: str) -> dict[str, object]:
    with JournalReader.open(visited.run) as reader:
        event = reader.last_event(kind)
    assert event is not None
    return dict(event.detail)


@pytest.mark.parametrize("act", ["pause", "continue", "stop", "ack"])
def test_a_button_asks_what_the_command_asks(alive: Visited, act: str) -> None:
    browser = alive.person("Anna Ray", "operate")
    answer = browser.post(f"{RUN}/{act}", data=alive.fields(browser), headers=OWN)
    assert (answer.status_code, answer.json()["done"]) == (202, True)
    (request,) = map(json.loads, alive.requests())
    assert (request["kind"], request["by"], request["via"], request["place"], request["key"], request["expects"]) == (
        act, "Anna Ray", "console", "127.0.0.1", "k1", alive.expects()
    )  # fmt: skip


def test_an_abort_is_heard_by_the_guard_before_anything_is_written(
    alive: Visited, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages: list[tuple[str, int]] = []

    def stop(guard: dict[str, str], axes: None, by: str) -> dict[str, str]:
        messages.append((by, len(alive.requests())))
        return {"pitch": "told to stop"}

    monkeypatch.setattr(acts, "of_run", lambda run, runs: [{"run": run}])
    monkeypatch.setattr(acts, "stop_by_guard", stop)
    browser = alive.person("Anna Ray", "operate")
    answer = browser.post(f"{RUN}/abort", data=alive.fields(browser, expects="1"), headers=OWN)
    assert answer.json()["told"] == "abort was asked for (pitch: told to stop)"
    assert messages == [("Anna Ray", 0)]
    assert json.loads(alive.requests()[0])["kind"] == "abort"


def test_an_abort_is_answered_from_no_memory(alive: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program may use a key again; whatever it asked by it before, of this run or of another, an abort aborts."""
    stopped: list[str] = []
    monkeypatch.setattr(acts, "of_run", lambda run, runs: [{"run": Path(run).name}])
    monkeypatch.setattr(acts, "stop_by_guard", lambda guard, axes, by: stopped.append(guard["run"]))
    browser = alive.enter()
    for _ in range(2):
        assert browser.post(f"{RUN}/note", data=alive.fields(browser, text="x"), headers=OWN).status_code == 202
    other = make_run(alive.run.parent / "night-2", State.PAUSED)
    with owning(other):
        path = "/api/v1/runs/night-2/abort"
        assert browser.post(path, data=alive.fields(browser), headers=OWN).status_code == 202
    for _ in range(2):
        assert browser.post(f"{RUN}/abort", data=alive.fields(browser), headers=OWN).status_code == 202
    kinds = [json.loads(request)["kind"] for request in alive.requests()]
    assert sorted(kinds) == ["abort", "abort", "note"], "a note by the same key counts once"
    assert stopped == ["night-2", "night-1", "night-1"]


@pytest.mark.parametrize("act", ["abort", "stop"])
def test_a_stop_that_was_refused_is_done_anew(alive: Visited, act: str) -> None:
    (alive.run / "requests").write_text("no folder")
    browser = alive.enter()
    fields = alive.fields(browser)
    assert browser.post(f"{RUN}/{act}", data=fields, headers=OWN).status_code == 409
    (alive.run / "requests").unlink()
    assert browser.post(f"{RUN}/{act}", data=fields, headers=OWN).status_code == 202
    assert json.loads(alive.requests()[0])["kind"] == act


def test_a_spool_that_takes_nothing_stops_the_axes_all_the_same(
    alive: Visited, monkeypatch: pytest.MonkeyPatch
) -> None:
    (alive.run / "requests").write_text("no folder")
    browser = alive.enter()
    assert browser.post(f"{RUN}/pause", data=alive.fields(browser), headers=OWN).status_code == 409
    assert browser.post(f"{RUN}/abort", data=alive.fields(browser, key="k2"), headers=OWN).status_code == 409
    monkeypatch.setattr(acts, "of_run", lambda run, runs: [{"run": run}])
    monkeypatch.setattr(acts, "stop_by_guard", lambda guard, axes, by: {"roll": "told to stop"})
    answer = browser.post(f"{RUN}/abort", data=alive.fields(browser, key="k3"), headers=OWN)
    assert answer.status_code == 202
    assert "roll: told to stop; the reason was not written down" in answer.json()["told"]


def test_who_says_what_stands_in_the_journal(ended: Visited) -> None:
    browser = ended.person("Anna Ray", "operate")
    note = browser.post(f"{RUN}/note", data=ended.fields(browser, text="the door\r\nwas open"), headers=OWN)
    assert note.status_code == 202
    said = _last(ended, "note")
    assert (said["by"], said["via"], said["place"]) == ("Anna Ray", "console", "127.0.0.1")
    assert said["text"] == "the door\nwas open"
    taken = browser.post(
        f"{RUN}/void", data=ended.fields(browser, key="k2", number="7", text="door"), headers=OWN
    ).json()
    assert taken["told"].startswith("2 dwells taken back")
    assert (_last(ended, "voided")["by"], _last(ended, "voided")["place"]) == ("Anna Ray", "127.0.0.1")


HIDDEN = ("bell \a", "\x1b[2Jgone", "left \u202e right", "over\rwritten", "a\u200bb")


@pytest.mark.parametrize("text", HIDDEN)
@pytest.mark.parametrize("act", ["note", "ack", "void", "redo", "pause"])
def test_words_that_the_command_refuses_are_refused_from_a_page(ended: Visited, act: str, text: str) -> None:
    browser = ended.enter()
    with JournalReader.open(ended.run) as reader:
        before = [event.kind for event in reader.events()]
    page = OWN | {"accept": "text/html"}
    fields = ended.fields(browser, text=text, **({"number": "1"} if act in ("void", "redo") else {}))
    answer = browser.post(f"{RUN}/{act}", data=fields, headers=page)
    assert answer.status_code == 400
    assert f"{act}: text: {text_complaint(text, PARAGRAPHS)}; nothing was done" in unescape(answer.text)
    with JournalReader.open(ended.run) as reader:
        assert [event.kind for event in reader.events()] == before


@pytest.mark.parametrize("text", HIDDEN)
def test_the_command_refuses_the_same_words(ended: Visited, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command(["note", str(ended.run), text, "--operator", "Anna"]) == 2
    assert text_complaint(text, PARAGRAPHS) in capsys.readouterr().err
    with pytest.raises(RequestError, match=r"note: text: holds <U\+.*nothing was noted"):
        add_note(ended.run, "Anna", text)


def test_a_reason_has_one_line_from_a_page_too(ended: Visited) -> None:
    browser = ended.enter()
    fields = ended.fields(browser, number="1", text="door\nopen")
    answer = browser.post(f"{RUN}/redo", data=fields, headers=OWN)
    assert (answer.status_code, "write it in one line" in answer.json()["told"]) == (400, True)


@pytest.mark.parametrize("text", HIDDEN)
def test_a_stop_is_taken_whatever_its_words_hold(alive: Visited, text: str) -> None:
    browser = alive.enter()
    assert browser.post(f"{RUN}/stop", data=alive.fields(browser, text=text), headers=OWN).status_code == 202
    (request,) = map(json.loads, alive.requests())
    assert request["text"] == one_line(text.strip())


def test_a_page_without_script_is_answered_with_a_page(ended: Visited) -> None:
    browser = ended.enter()
    answer = browser.post(
        f"{RUN}/redo",
        data=ended.fields(browser, number="1", text="<b>door</b>"),
        headers=OWN | {"accept": "text/html"},
    )
    assert answer.status_code == 202
    assert "dwells taken back" in answer.text
    assert 'href="/run/night-1"' in answer.text


@pytest.mark.parametrize("act", ["continue", "pause", "ack", "void", "redo"])
@pytest.mark.parametrize("expects", ["", "1", "999"])
def test_what_was_asked_in_view_of_another_state_is_refused(alive: Visited, act: str, expects: str) -> None:
    browser = alive.enter()
    fields = alive.fields(browser, expects=expects, number="1", text="why")
    assert browser.post(f"{RUN}/{act}", data=fields, headers=OWN).status_code == 409
    assert alive.requests() == []


def test_an_act_that_is_sent_again_counts_once(alive: Visited) -> None:
    browser = alive.enter()
    answers = [browser.post(f"{RUN}/continue", data=alive.fields(browser), headers=OWN) for _ in range(3)]
    assert [answer.status_code for answer in answers] == [202] * 3
    assert len(alive.requests()) == 1


def test_too_many_acts_are_refused_but_never_a_stop(alive: Visited) -> None:
    browser = alive.enter()
    codes = [
        browser.post(f"{RUN}/note", data=alive.fields(browser, key=f"n{n}", text="x"), headers=OWN).status_code
        for n in range(ACTS + 2)
    ]
    assert codes == [202] * ACTS + [429] * 2
    assert browser.post(f"{RUN}/stop", data=alive.fields(browser, key="s"), headers=OWN).status_code == 202
    alive.clock.sleep(61.0)
    assert browser.post(f"{RUN}/note", data=alive.fields(browser, key="z", text="x"), headers=OWN).status_code == 202


Attack = Callable[[Visited, TestClient], tuple[TestClient, dict[str, str], dict[str, str]]]


def _other_csrf(visited: Visited, browser: TestClient) -> str:
    return visited.csrf(visited.person("Mallory", "move"))


ATTACKS: dict[str, tuple[int, Attack]] = {
    "no cookie": (401, lambda v, b: (v.new_browser(), v.fields(b), OWN)),
    "a bad token": (401, lambda v, b: (v.new_browser(), v.fields(b), OWN | {"cookie": f"calrig={'a' * 43}"})),
    "no origin": (403, lambda v, b: (b, v.fields(b), {})),
    "a foreign origin": (403, lambda v, b: (b, v.fields(b), {"origin": "https://evil.example"})),
    "a form of a page without an origin": (403, lambda v, b: (b, v.fields(b), {"origin": "null"})),
    "another port of this machine": (403, lambda v, b: (b, v.fields(b), {"origin": "http://127.0.0.1:9"})),
    "a cross-site fetch": (403, lambda v, b: (b, v.fields(b), OWN | {"sec-fetch-site": "cross-site"})),
    "a bent name": (421, lambda v, b: (b, v.fields(b), {"host": "evil.example", "origin": "http://evil.example"})),
    "no token of the page": (403, lambda v, b: (b, v.fields(b, csrf=""), OWN)),
    "the token of another session": (403, lambda v, b: (b, v.fields(b, csrf=_other_csrf(v, b)), OWN)),
    "no key": (400, lambda v, b: (b, v.fields(b, key=""), OWN)),
    "a key that is none": (400, lambda v, b: (b, v.fields(b, key="a\r\nb"), OWN)),
    "expects that is no number": (400, lambda v, b: (b, v.fields(b, expects="1e3"), OWN)),
    "a plain text as a form of another site sends": (
        415, lambda v, b: (b, v.fields(b), OWN | {"content-type": "text/plain"}),
    ),
    "a body too long": (413, lambda v, b: (b, v.fields(b, text="x" * LONGEST_BODY), OWN)),
    "many fields": (400, lambda v, b: (b, v.fields(b) | {f"f{n}": "x" for n in range(30)}, OWN)),
    "who may only look": (403, lambda v, b: _as_watcher(v)),
}  # fmt: skip


def _as_watcher(visited: Visited) -> tuple[TestClient, dict[str, str], dict[str, str]]:
    browser = visited.person("Wim Watcher", "watch")
    return browser, visited.fields(browser, role="move"), OWN | {"x-role": "move"}


@pytest.mark.parametrize("name", ATTACKS)
def test_each_attack_is_refused_and_the_run_is_as_it_was(alive: Visited, name: str) -> None:
    code, attack = ATTACKS[name]
    before = alive.digest()
    browser, fields, headers = attack(alive, alive.enter())
    for act in ("continue", "stop", "abort", "note"):
        assert browser.post(f"{RUN}/{act}", data={"text": "x"} | fields, headers=headers).status_code == code
    assert alive.requests() == []
    assert alive.digest() == before


@pytest.mark.parametrize("path", ["night-1/continue", "night-1/abort"])
def test_no_act_is_asked_for_by_a_link(alive: Visited, path: str) -> None:
    for target in (f"/api/v1/runs/{path}", f"/api/v1/runs/{path}?key=a&expects=3"):
        assert alive.enter().get(target).status_code in (404, 405)
    assert alive.requests() == []


@pytest.mark.parametrize("name", ["..", "%2e%2e", "..%2f..", "linked", ".hidden", "no-such", "night-1%00", "a%5cb"])
def test_no_act_leads_out_of_the_folder_of_runs(alive: Visited, name: str) -> None:
    (alive.run.parent / "linked").symlink_to(alive.run, target_is_directory=True)
    browser = alive.enter()
    answer = browser.post(f"/api/v1/runs/{name}/stop", data=alive.fields(browser), headers=OWN)
    assert answer.status_code in (404, 405)
    assert alive.requests() == []


@pytest.mark.parametrize("body", [b"[1]", b"{", b"\xff", b'{"key": {"a": 1}}', b"[" * 9000])
def test_what_is_no_act_is_refused(alive: Visited, body: bytes) -> None:
    browser = alive.enter()
    headers = OWN | {"content-type": "application/json", "x-csrf-token": alive.csrf(browser)}
    assert browser.post(f"{RUN}/stop", content=body, headers=headers).status_code == 400
    assert alive.requests() == []


@pytest.mark.parametrize(("how", "status"), [("slow", 408), ("endless", 413)])
def test_a_body_that_does_not_end_is_given_up(monkeypatch: pytest.MonkeyPatch, how: str, status: int) -> None:
    """One that stops in its middle, and one that says no length and goes on: neither keeps a place or fills memory."""
    monkeypatch.setattr(gate, "BODY_S", 0.05)
    taken = 0

    async def receive() -> Message:
        nonlocal taken
        if how == "slow" and taken:
            await asyncio.Event().wait()
        taken += 1
        return {"type": "http.request", "body": b"a" * 1000, "more_body": True}

    headers = [(b"content-type", b"application/x-www-form-urlencoded")]
    request = Request({"type": "http", "method": "POST", "headers": headers}, receive)
    with pytest.raises(HTTPException) as refused:
        asyncio.run(gate.read_fields(request))
    assert refused.value.status_code == status
    assert taken <= gate.LONGEST_BODY // 1000 + 1


def test_programs_send_the_same_as_json(alive: Visited) -> None:
    browser = alive.enter()
    headers = OWN | {"x-csrf-token": alive.csrf(browser)}
    answer = browser.post(f"{RUN}/continue", json={"key": "k", "expects": alive.expects()}, headers=headers)
    assert answer.status_code == 202


def test_motion_is_not_begun_from_another_machine(alive: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    browser = alive.person("Anna Ray", "move", ELSEWHERE)
    refused = browser.post(f"{RUN}/continue", data=alive.fields(browser), headers=OWN)
    assert refused.status_code == 403
    assert "motion_from_elsewhere" in refused.json()["told"]
    rig = alive.console.rig_of(alive.run)
    allowing = rig.model_copy(update={"console": rig.console.model_copy(update={"motion_from_elsewhere": True})})
    monkeypatch.setattr(type(alive.console), "rig_of", lambda self, folder: allowing)
    uncoded = browser.post(f"{RUN}/continue", data=alive.fields(browser, key="k2"), headers=OWN)
    assert "the code that stands on the terminal" in uncoded.json()["told"]
    code = alive.sessions.new_code()
    text = browser.post("/code", data={"csrf": alive.csrf(browser), "code": code}, headers=OWN)
    assert text.status_code == 200
    assert browser.post(f"{RUN}/continue", data=alive.fields(browser, key="k3"), headers=OWN).status_code == 202
    assert browser.post("/code", data={"csrf": alive.csrf(browser), "code": code}, headers=OWN).status_code == 403
    assert browser.post(f"{RUN}/stop", data=alive.fields(browser, key="k4"), headers=OWN).status_code == 202


def test_a_code_is_not_found_by_trying(alive: Visited) -> None:
    browser = alive.person("Anna Ray", "move", ELSEWHERE)
    code = alive.sessions.new_code()
    token = {"csrf": alive.csrf(browser)}
    for guess in range(MOST_WRONG_SECRETS):
        assert browser.post("/code", data=token | {"code": str(guess)}, headers=OWN).status_code == 403
    assert browser.post("/code", data=token | {"code": code}, headers=OWN).status_code == 403, "locked"
    alive.clock.sleep(61.0)
    assert browser.post("/code", data=token | {"code": code}, headers=OWN).status_code == 200


def test_a_secret_is_not_found_by_trying(alive: Visited) -> None:
    secret = alive.people.add("Anna Ray", "operate", alive.clock.now_utc())
    browser = alive.new_browser()

    def tries(name: str, word: str) -> int:
        return browser.post("/login", data={"name": name, "secret": word}, headers=OWN).status_code

    assert [tries("anna ray", "guess") for _ in range(MOST_WRONG_SECRETS)] == [403] * MOST_WRONG_SECRETS
    assert tries("Anna Ray", secret) == 403, "the name is locked, in any spelling"
    assert tries("Nobody", "guess") == 403
    alive.clock.sleep(61.0)
    assert tries("Anna Ray", secret.upper().replace("-", " ")) == 303, "as it is read out and typed"


def test_a_session_is_new_with_every_entrance_and_ends_with_its_account(alive: Visited) -> None:
    planted = "attackers-choice"
    secret = alive.people.add("Anna Ray", "operate", alive.clock.now_utc())
    browser = alive.new_browser()
    headers = OWN | {"cookie": f"calrig={planted}"}
    browser.post("/login", data={"name": "Anna Ray", "secret": secret}, headers=headers)
    first = browser.cookies["calrig"]
    assert first != planted
    browser.post("/login", data={"name": "Anna Ray", "secret": secret}, headers=OWN)
    assert alive.sessions.visitor(first) is None, "the session before ended"
    assert browser.get("/").status_code == 200
    alive.people.add("Anna Ray", "watch", alive.clock.now_utc(), renews=True)
    assert browser.get("/").status_code == 401, "another role or secret"


@pytest.mark.parametrize("end", ["leave", "expiry", "removal"])
def test_a_session_that_ended_steers_nothing_and_closes_its_sockets(alive: Visited, end: str) -> None:
    browser = alive.person("Anna Ray", "operate")
    fields = alive.fields(browser)
    with browser.websocket_connect(f"ws://{BASE[7:]}/live/night-1", headers=OWN) as socket:
        news = socket.receive_json()
        assert "Pause" not in news["acts"]
        assert "Continue" in news["acts"]
        token = browser.cookies["calrig"]
        match end:
            case "leave":
                assert browser.post("/leave", data={"csrf": fields["csrf"]}, headers=OWN).status_code == 303
            case "expiry":
                alive.clock.sleep(LIFE_S)
            case "removal":
                alive.people.remove("Anna Ray")
        headers = OWN | {"cookie": f"calrig={token}"}
        assert alive.new_browser().post(f"{RUN}/stop", data=fields, headers=headers).status_code == 401
        with pytest.raises(WebSocketDisconnect) as closed:
            _hear_until_it_ends(socket)
        assert closed.value.code == 1008
    assert alive.requests() == []


def _hear_until_it_ends(socket: WebSocketTestSession) -> None:
    for _ in range(20):
        socket.receive_json()


def test_a_watcher_is_offered_nothing(alive: Visited) -> None:
    page = alive.person("Wim", "watch").get("/run/night-1").text
    assert "<button>Continue" not in page
    assert "Stop axes" not in page


def test_names_and_secrets_are_kept_as_hashes_alone(tmp_path: Path, alive: Visited) -> None:
    people = People(tmp_path / "others.json", cost=CHEAP)
    secret = people.add("Anna  Ray", "operate", alive.clock.now_utc())
    text = people.path.read_text()
    assert secret not in text
    assert secret.replace("-", "") not in text
    assert people.path.stat().st_mode & 0o077 == 0
    with pytest.raises(RequestError, match="has an account already"):
        people.add("anna ray", "watch", alive.clock.now_utc())
    assert people.identify("ANNA RAY", secret) is not None
    assert people.identify("Anna Ray", secret[:-1]) is None
    people.path.write_text("{")
    with pytest.raises(RequestError, match="is no file of people"):
        people.read()


@pytest.mark.parametrize(("name", "role"), [("", "watch"), ("a\u202eb", "watch"), ("x" * 65, "watch"), ("A", "root")])
def test_an_account_needs_a_name_and_a_role(tmp_path: Path, alive: Visited, name: str, role: str) -> None:
    with pytest.raises(RequestError, match="nobody was added"):
        People(tmp_path / "p.json").add(name, role, alive.clock.now_utc())
