"""live.json: what the engine does now, seldom written, never in its way, believed of living engines alone."""

import json
from pathlib import Path

import pytest
from journals import a_clock
from small_run import bench

from procedures.journal.sidecar.live import LIVE_FILE, Figure, LiveFile, Target, live_document, read_live
from procedures.journal.sidecar.owner import owning
from procedures.records.progress import Progress


class Looking:
    """An observer that reads the file of the very run that tells it."""

    def __init__(self, run_dir: Path) -> None:
        self._run_dir = run_dir
        self.seen: list[object] = []

    def on_event(self, progress: Progress) -> None:
        self.seen.append(read_live(self._run_dir))


def test_what_was_told_is_what_is_read(tmp_path: Path) -> None:
    live = LiveFile(tmp_path, a_clock())
    live.tell("soaking", setpoint_degc={"air": 20.0}, soak_left_s=float("nan"))
    live.tell(now=Target(7, "design", 2, {"pitch": -70.0}), readings={"dmm.x": Figure(None, "v")})
    with owning(tmp_path):
        live.look()
        found = read_live(tmp_path)
    assert found is not None
    assert (found.phase, found.setpoint_degc, found.soak_left_s) == ("soaking", {"air": 20.0}, None)
    assert found.now == Target(7, "design", 2, {"pitch": -70.0})
    assert found.readings["dmm.x"].value is None
    json.dumps(live_document(found), allow_nan=False)


def test_it_is_written_at_most_once_a_second_and_only_when_something_is_new(tmp_path: Path) -> None:
    clock = a_clock()
    live, written = LiveFile(tmp_path, clock), 0
    for tenth in range(100):
        if tenth < 60:
            live.tell("reading", soak_left_s=float(tenth))
        live.look()
        written += (tmp_path / LIVE_FILE).exists()
        (tmp_path / LIVE_FILE).unlink(missing_ok=True)
        clock.sleep(0.1)
    assert 5 <= written <= 7


def test_a_new_phase_is_written_before_what_may_keep_the_engine_from_looking(tmp_path: Path) -> None:
    """A device that is silent from the first question on blocks for seconds: what it was asked for stands there."""
    live = LiveFile(tmp_path, a_clock(), writes_phases=True)
    with owning(tmp_path):
        for phase in ("reading", "moving"):
            live.tell(phase)
            found = read_live(tmp_path)
            assert found is not None
            assert found.phase == phase
        live.tell(soak_left_s=1.0)
        assert read_live(tmp_path) == found, "what is no phase waits for a look"


def test_a_new_phase_forgets_what_the_one_before_waited_for(tmp_path: Path) -> None:
    live = LiveFile(tmp_path, a_clock())
    live.tell("soaking", soak_left_s=60.0)
    live.tell("moving")
    with owning(tmp_path):
        live.look()
        found = read_live(tmp_path)
    assert found is not None
    assert (found.phase, found.soak_left_s) == ("moving", None)


def test_a_folder_that_takes_nothing_holds_nobody(tmp_path: Path) -> None:
    live = LiveFile(tmp_path / "gone", a_clock())
    live.tell("moving")
    live.look()
    live.remove()


def test_what_a_kill_left_half_written_goes_with_it(tmp_path: Path) -> None:
    live = LiveFile(tmp_path, a_clock())
    live.tell("moving")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.replace", _killed)
        patch.setattr(Path, "unlink", lambda *_, **__: None)  # a killed process clears nothing
        with pytest.raises(KeyboardInterrupt):
            live.look()
    assert len(list(tmp_path.iterdir())) == 1
    live.remove()
    assert list(tmp_path.iterdir()) == []


def _killed(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("content", ["", "{", "[]", '{"phase": 7}', '{"positions_deg": {"pitch": "x"}}', "[" * 9000])
def test_what_is_no_such_file_is_not_believed(tmp_path: Path, content: str) -> None:
    (tmp_path / LIVE_FILE).write_text(content)
    with owning(tmp_path):
        assert read_live(tmp_path) is None


def test_a_run_leaves_none_behind_and_nobody_believes_that_of_a_dead_one(tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    looking = Looking(run_dir)
    bench(tmp_path).run(run_dir, observer=looking)
    assert any(looking.seen)
    assert not (run_dir / LIVE_FILE).exists()
    (run_dir / LIVE_FILE).write_text('{"phase": "moving"}')
    assert read_live(run_dir) is None
