"""The runner as a process, killed with -9 at random moments: each item is measured once, and as without a queue."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from small_run import PROCEDURE, RIG

from procedures.journal.journal_reader import JournalReader
from procedures.records.dwells import DwellRecord

LEAST_KILLS, MOST_KILLS = 100, 600
LONGEST_LIFE_S = 6.0
"""Of a runner: on an idle machine it has then checked and begun an item, and seen it end."""
CALRIG = (sys.executable, "-m", "procedures.cli.main")
ANNA = ("--operator", "Anna")


def _calrig(folder: Path, *words: str) -> str:
    done = subprocess.run([*CALRIG, *words], cwd=folder, env=_environment(folder), capture_output=True, timeout=120)
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.decode()


def _environment(folder: Path) -> dict[str, str]:
    return {**os.environ, "CALRIG_QUEUES": str(folder / "queues")}


def _add(folder: Path) -> None:
    _calrig(folder, "queue", "add", "procedure.toml", "--rig", "rig.toml", "--out", "runs", *ANNA)
    _calrig(folder, "queue", "attest", "SN1", *ANNA)


def _places(folder: Path) -> list[str]:
    return [load["place"] for load in json.loads(_calrig(folder, "queue", "list", "--json"))["items"]]


def _runner_lives(folder: Path, for_s: float) -> None:
    """Run it for so long, then kill it as a power cut of its own would."""
    process = subprocess.Popen(
        [*CALRIG, "queue", "run", "--archive", f"sqlite:///{folder}/archive.sqlite"],
        cwd=folder, env=_environment(folder), stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        process.wait(for_s)
        raise AssertionError("the runner ended by itself")
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _dwells(run: Path) -> list[object]:
    with JournalReader.open(run) as reader:
        return [(dwell.step, dwell.attempt, _samples(dwell)) for dwell in reader.dwells()]


def _samples(dwell: DwellRecord) -> list[object]:
    return [(name, reading.samples.tolist()) for name, reading in sorted(dwell.readings.items())]


def _coefficients(run: Path) -> object:
    (found,) = (run / "coefficients").glob("*.json")
    document = json.loads(found.read_text())
    return document["axes"], document["package"]


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_a_runner_that_is_killed_at_random_moments_measures_each_item_once(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG)
    (tmp_path / "procedure.toml").write_text(PROCEDURE)
    archive = f"sqlite:///{tmp_path}/alone.sqlite"
    _calrig(tmp_path, "run", "procedure.toml", "--rig", "rig.toml", "--out", "alone", "--archive", archive, *ANNA)
    _add(tmp_path)
    chance, kills = np.random.default_rng(3), 0
    while set(indices := _places(tmp_path)) != {"finished"} or kills < LEAST_KILLS:
        if set(indices) == {"finished"}:
            _add(tmp_path)
        if "needs a decision" in indices:  # killed between the line and the process
            number = str(indices.index("needs a decision") + 1)
            _calrig(tmp_path, "queue", "decide", number, "again", "--reason", "nothing began", *ANNA)
        if not json.loads(_calrig(tmp_path, "queue", "list", "--json"))["armed"]:
            _calrig(tmp_path, "queue", "arm", "--until", "2099-01-01T00:00", *ANNA)
        _runner_lives(tmp_path, float(chance.uniform(0.5, LONGEST_LIFE_S)))
        kills += 1
        assert kills < MOST_KILLS
    items = len(_places(tmp_path))
    (alone,) = [entry.parent for entry in (tmp_path / "alone").glob("*/journal.sqlite")]
    runs = [entry.parent for entry in (tmp_path / "runs").glob("*/journal.sqlite")]
    assert len(runs) == items > 5, "an item that needed a decision had begun nothing"
    for run in runs:
        assert _dwells(run) == _dwells(alone)
        assert _coefficients(run) == _coefficients(alone)
