"""The page on rehearsing faults works as it is told: its file, its two terminals, its lines of Python."""

import doctest
import re
import shlex
import shutil
from pathlib import Path

import pytest
from command import call
from job_files import job, simulated

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "rehearsing-faults.md"
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks_of(language: str) -> list[str]:
    return [block for named, block in FENCED.findall(PAGE.read_text(encoding="utf-8")) if named == language]


@pytest.mark.thorough
def test_the_two_terminals_run_to_the_end_beside_the_faults(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    job(tmp_path)
    (tmp_path / "faults.toml").write_text(blocks_of("toml")[0], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    served, run = (shlex.split(block) for block in blocks_of(""))
    assert served[:2] == ["calrig", "simulate"]
    rig, written = served[2], served[served.index("--write") + 1]
    others = [word for word in served[3:] if word not in ("--write", written)]
    with simulated(rig, Path(written), *others):
        outcome = call(capsys, *run[1:], "--archive", f"sqlite:///{tmp_path / 'archive.sqlite'}")
    assert outcome.status == 0, outcome.err


def test_what_it_shows_in_python_is_what_happens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(ROOT / "examples" / "rig.toml", tmp_path)
    (tmp_path / "faults.toml").write_text(blocks_of("toml")[0], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    results = doctest.testfile(str(PAGE), module_relative=False, encoding="utf-8")
    assert results.attempted > 5
    assert results.failed == 0
