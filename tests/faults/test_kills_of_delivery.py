"""A kill while a run is solved, published, reported or exported: final names are absent or complete, and delivering
again leaves what an undisturbed delivery leaves, byte for byte."""

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import pytest
from device_sets import CAMPAIGN, device_set
from small_run import in_child, resumed

from ams.archive.sets import list_sets
from ams.exports.formats import FORMATS, export_set
from procedures.delivery.deliver import sets_of, solve_run
from procedures.errors import RequestError
from procedures.records.states import State
from rig.crash_points import CrashPoint

pytestmark = pytest.mark.timeout(600)
POINTS = (CrashPoint.SOLVED, CrashPoint.SETS_WRITTEN, CrashPoint.PUBLISHED, CrashPoint.REPORTED)
LEFT = ("report.html", "coefficients/SN1.json", "exports/SN1.csv", "exports/SN1.h")
FILE_CALLS = ("open", "write", "fsync", "replace", "rename", "close")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """``clean`` was delivered once; ``killed`` is the same run, whose delivery was killed everywhere, then repeated."""
    folder = tmp_path_factory.mktemp("delivery")
    bench = device_set("table-3458a", folder, CAMPAIGN + '[export]\nformats = ["csv", "c"]\n')
    for name in ("clean", "killed"):
        (folder / name).mkdir()
    assert bench.run(folder / "clean" / "run").state is State.FINISHED
    shutil.copytree(folder / "clean" / "run", folder / "killed" / "run")
    return folder


@pytest.fixture(scope="module")
def delivered(finished: Path) -> list[bool]:
    """Which of the deliveries of ``killed`` were killed."""
    _delivered(finished / "clean", ())
    return _delivered(finished / "killed", POINTS)


def _delivered(folder: Path, points: tuple[str, ...]) -> list[bool]:
    """In a process of its own: the typesetter keeps threads, which a fork does not carry over."""
    program = Path(__file__).parents[1] / "support" / "killed_deliveries.py"
    done = subprocess.run(
        [sys.executable, program, folder / "run", _archive(folder), *points],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": f"{program.parent}{os.pathsep}{program.parents[2]}"},
    )
    return list(json.loads(done.stdout))


def _archive(folder: Path) -> str:
    return f"sqlite:///{folder}/archive.sqlite"


@pytest.mark.thorough
def test_fault_01_a_delivery_killed_at_every_place_is_delivered_again_the_same(
    finished: Path, delivered: list[bool]
) -> None:
    assert delivered == [True] * len(POINTS) + [False]
    for name in LEFT:
        here, there = (finished / folder / "run" / name for folder in ("killed", "clean"))
        assert here.read_bytes() == there.read_bytes(), name
    assert len(list_sets(_archive(finished / "killed"))) == 1, "published more than once"


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.thorough)])
def test_fault_12_an_export_killed_at_any_file_call_leaves_the_whole_file_or_none(
    finished: Path, tmp_path: Path, every: int
) -> None:
    """The n-th call of the system, n = 1, 1 + every, … until an export is not killed any more."""
    coefficients = sets_of(solve_run(finished / "clean" / "run"))["SN1"]
    for kind in ("json", "csv", "c"):
        whole = FORMATS[kind].to_bytes(coefficients)
        path, call = tmp_path / FORMATS[kind].file_name("SN1"), 1
        while _killed(lambda: _export(coefficients, kind, path, call)):  # noqa: B023 called at once
            call += every
            assert not path.exists() or path.read_bytes() == whole
            path.unlink(missing_ok=True)
        assert path.read_bytes() == whole
        assert call > 4, "opened, synced, renamed, and the folder synced"


def _killed(work: Callable[[], object]) -> bool:
    _, ended = os.waitpid(in_child(work), 0)
    assert os.WIFSIGNALED(ended) or os.waitstatus_to_exitcode(ended) == 0, "the child failed by itself"
    return os.WIFSIGNALED(ended)


def _export(coefficients: object, kind: str, path: Path, call: int) -> None:
    with _killing(call):
        export_set(coefficients, kind, path)  # type: ignore[arg-type]


@contextmanager
def _killing(call: int) -> Iterator[None]:
    """SIGKILL before the ``call``-th file call of the module ``os``; in a child only."""
    left = call

    def before(function: Callable[..., object]) -> Callable[..., object]:
        def counted(*arguments: object, **named: object) -> object:
            nonlocal left
            left -= 1
            if left == 0:
                _die()
            return function(*arguments, **named)

        return counted

    for name in FILE_CALLS:
        setattr(os, name, before(getattr(os, name)))
    yield


def _die() -> NoReturn:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError("a killed process goes on")


def test_fault_01_a_run_killed_after_its_journal_was_closed_is_delivered_by_solve(finished: Path) -> None:
    """No stale half report: a finished run needs no resume, and refuses one."""
    with pytest.raises(RequestError, match="the run is finished, and resume takes"):
        resumed(finished / "clean" / "run")
