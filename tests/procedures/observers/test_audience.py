"""Observers of other distributions are told, and whatever becomes of them a run goes on."""

from pathlib import Path

import pytest
from installed_examples import install

from procedures.observers.audience import with_observers
from procedures.observers.metrics_file import VARIABLE
from procedures.records.progress import Progress
from procedures.records.states import State

MOMENT = Progress("state", State.RUNNING, 3, 24, 1, 2, None, None, "")
OBSERVER = """
from procedures.observers.audience import ObserverKind
class Told:
    def __init__(self, run_dir):
        self.file = run_dir / "told"
    def on_event(self, progress):
        self.file.write_text(self.file.read_text() + "." if self.file.exists() else ".")
        if progress.dwells_done == 4:
            raise RuntimeError("no line to the display")
def _broken(run_dir):
    raise OSError("no display")
OBSERVER = ObserverKind("wall", Told)
BROKEN = ObserverKind("broken", _broken)
"""


class Screen:
    def __init__(self) -> None:
        self.seen: list[Progress] = []

    def on_event(self, progress: Progress) -> None:
        self.seen.append(progress)


def test_others_are_told_until_they_fail_and_the_first_always(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wall_observer.py").write_text(OBSERVER)
    group = {"calrig.observers": {"wall": "wall_observer:OBSERVER", "broken": "wall_observer:BROKEN"}}
    install("wall", group, tmp_path / "site", monkeypatch)
    monkeypatch.syspath_prepend(str(tmp_path))
    screen, failures = Screen(), list[str]()
    audience = with_observers(screen, tmp_path, failures.append)
    for done in (3, 4, 5):
        audience.on_event(Progress("dwell", State.RUNNING, done, 24, 1, 2, None, None, ""))
    assert (len(screen.seen), (tmp_path / "told").read_text()) == (3, "..")
    assert failures == [
        "observer broken: OSError: no display; the run goes on without it",
        "observer wall: RuntimeError: no line to the display; it is told no more; the run goes on",
    ]


def test_metrics_are_written_where_a_file_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "calrig.prom"))
    with_observers(Screen(), tmp_path / "run", pytest.fail).on_event(MOMENT)
    assert 'calrig_run_state{run="run",state="running"} 1' in (tmp_path / "calrig.prom").read_text()
    assert [path.name for path in tmp_path.iterdir()] == ["calrig.prom"]


def test_without_any_there_is_the_screen_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    screen = Screen()
    assert with_observers(screen, tmp_path, pytest.fail) is screen
