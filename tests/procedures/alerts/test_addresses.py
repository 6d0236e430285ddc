"""Whether a file of alerts can tell anybody: refused before a run moves, and tried while somebody looks."""

import json
import sys
from pathlib import Path

import pytest
from alert_sink import POSTS, alert_sink
from command import call
from small_run import PROCEDURE, RIG

from procedures.alerts.addresses import usable_alerts
from procedures.alerts.channels import Message, NotDelivered, by_apprise
from rig.errors import DescriptionError

pytest.importorskip("apprise")
pytestmark = pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")

NO_SUCH = "apprise knows no such service"
WRONG = [
    (
        'urls = ["json://127.0.0.1/rig", "jsn://u:hushhush@127.0.0.1/rig"]',
        f"urls: got jsn://… (value 2): {NO_SUCH}; did you mean json://?",
    ),
    ('urls = ["tgram://hushhush"]', "urls: got tgram://… (value 1): apprise cannot read it as an address"),
    ('urls = ["hushhush"]', f"urls: got … (value 1): {NO_SUCH}"),
    ('[escalate]\nurls = ["jsn://hushhush"]', f"escalate.urls: got jsn://… (value 1): {NO_SUCH}"),
    ('command = ["no-such-program", "--token=hushhush"]', "command: got no-such-program: there is no such program"),
]


def _alerts(folder: Path, text: str) -> Path:
    file = folder / "alerts.toml"
    file.write_text(f"{text}\n", encoding="utf-8")
    return file


@pytest.mark.parametrize(("text", "said"), WRONG)
def test_an_address_that_can_never_work_is_refused_by_line_and_key_and_starred(
    tmp_path: Path, text: str, said: str
) -> None:
    with pytest.raises(DescriptionError) as refused:
        usable_alerts(_alerts(tmp_path, text))
    assert f"alerts.toml:{text.count(chr(10)) + 1}: {said}" in str(refused.value)
    assert "hushhush" not in str(refused.value)


def test_an_address_that_may_work_is_taken_whoever_answers_there(tmp_path: Path) -> None:
    urls = ["json://u:word@127.0.0.1:9/rig", "mailto://127.0.0.1:9?from=rig@lab.example&to=me@lab.example"]
    settings = usable_alerts(_alerts(tmp_path, f"urls = {json.dumps(urls)}"))
    assert settings is not None
    assert settings.urls == tuple(urls)


@pytest.mark.parametrize("command", ["check", "run", "queue add"])
def test_a_run_is_refused_before_it_has_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """By the user's own file, which a queue reads as well."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "calrig").mkdir()
    _alerts(tmp_path / "calrig", WRONG[0][0])
    (tmp_path / "rig.toml").write_text(RIG.replace("seed = 7", 'seed = 7\ntime = "real"'), encoding="utf-8")
    (tmp_path / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    words = [tmp_path / "procedure.toml", "--rig", tmp_path / "rig.toml", "--out", tmp_path / "runs"]
    outcome = call(capsys, *command.split(), *words)
    assert outcome.status == 2
    assert WRONG[0][1] in outcome.out + outcome.err
    assert not list(tmp_path.glob("runs/*/journal.sqlite"))


def test_a_trial_tells_everybody_once_and_says_who_was_not_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with alert_sink() as sink:
        command = json.dumps([sys.executable, "-c", POSTS, f"{sink.address}/desk"])
        urls = json.dumps(
            [f"json://u:hushhush@{sink.address.removeprefix('http://')}/first", "json://127.0.0.1:9/dead"]
        )
        others = json.dumps([f"json://{sink.address.removeprefix('http://')}/others"])
        file = _alerts(tmp_path, f"command = {command}\nurls = {urls}\n[escalate]\nurls = {others}")
        assert call(capsys, "alerts", file).status == 0
        assert sink.received == [], "nobody is told without --test"
        outcome = call(capsys, "alerts", file, "--test")
    assert sorted(path for path, _ in sink.received) == ["/desk", "/first", "/others"]
    assert all("This is a trial" in text for _, text in sink.received)
    assert outcome.status == 1
    assert "urls: json://… (value 1): taken" in outcome.out
    assert "urls: json://… (value 2): not delivered: apprise: json://… did not take the message" in outcome.out
    assert "hushhush" not in outcome.out


def test_an_address_that_fails_keeps_no_other_from_its_message() -> None:
    with alert_sink() as sink:
        host = sink.address.removeprefix("http://")
        urls = [f"json://{host}/first", "jsn://x", "json://127.0.0.1:9/dead", f"json://{host}/last"]
        with pytest.raises(NotDelivered) as failed:
            by_apprise(urls, Message("calrig: night: tripped", "look"))
    assert [path for path, _ in sink.received] == ["/first", "/last"]
    assert str(failed.value) == ("apprise: jsn://… is no address that it knows, json://… did not take the message")
