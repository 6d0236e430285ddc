"""A kind of run that is no part of the package is read, refused, planned, foretold and stored (examples/own_kind)."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from installed_examples import install_example

from procedures.check.check_report import check, to_document
from procedures.errors import PlanError
from procedures.journal.header import make_header
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_record
from procedures.plan.plan import Plan
from procedures.run.begin import begin
from procedures.solution.record import RunRecord, read_record
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.errors import DescriptionError

EXAMPLE = Path(__file__).parents[3] / "examples" / "servo-mechanism" / "rig.toml"


@pytest.fixture(autouse=True)
def _installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install_example("own_kind", tmp_path / "site", monkeypatch)


def _file(folder: Path, table: str, kind: str = "leaning", replications: int = 2) -> Path:
    path = folder / "procedure.toml"
    head = f'[procedure]\ntitle = "t"\nkind = "{kind}"\nreplications = {replications}'
    text = f'{head}\n{table}\n[solve]\nmodel = "linear"\n'
    path.write_text(text, encoding="utf-8")
    return path


def test_it_is_read_planned_foretold_and_stored(tmp_path: Path) -> None:
    rig = read_rig(EXAMPLE)
    procedure = read_procedure(_file(tmp_path, "[lean]\npitch_deg = 30.0\nby_deg = 5.0"))
    plan = make_plan(rig, procedure)
    assert [dwell.targets_deg["pitch"] for dwell in plan.design_dwells] == [25.0, 30.0, 35.0] * 2
    assert Plan.from_json(plan.to_json()) == plan
    document = to_document(check(rig, procedure))
    assert (document["kind"], document["steps"][0]) == ("leaning", "at rest at pitch 25° for 10 s")


def test_it_solves_by_its_own_table(tmp_path: Path) -> None:
    """The first of three replications warms up: what is solved is the rows of the last two, to the bit."""
    record = _run(tmp_path, "[lean]\npitch_deg = 30.0\nby_deg = 5.0\nrest_s = 1.0\nwarming_up = 1")
    all_used = {"lean": {**record.plan.kind_settings["lean"], "warming_up": 0}}
    plans = (record.plan, replace(record.plan, kind_settings=all_used))
    warm, every = (next(iter(solve_record(replace(record, plan=plan)).values())) for plan in plans)
    assert {*every.observations.replication.tolist()} == {1, 2, 3}
    assert {*warm.observations.replication.tolist()} == {2, 3}
    kept = every.observations.replication > 1
    for axis, readings in warm.observations.outputs.items():
        np.testing.assert_array_equal(readings, every.observations.outputs[axis][kept])
    assert warm.failure is None
    assert every.failure is None


def test_nothing_left_to_solve_is_refused_by_its_key(tmp_path: Path) -> None:
    path = _file(tmp_path, "[lean]\npitch_deg = 30.0\nby_deg = 5.0\nwarming_up = 2")
    with pytest.raises(DescriptionError, match=r"procedure\.toml:8: lean\.warming_up: got 2: nothing is left"):
        read_procedure(path)


def _run(folder: Path, table: str) -> RunRecord:
    """Run three replications on the twins; return what the journal holds."""
    path, rig, run = _file(folder, table, replications=3), read_rig(EXAMPLE), folder / "run"
    run.mkdir()
    plan = make_plan(rig, read_procedure(path))
    with open_rig(rig) as opened:
        outcome = begin(run, make_header(run.name, plan, rig, EXAMPLE, path, "tester", datetime.now(UTC)), plan, opened)
    assert outcome.exit_status == 0, outcome.reason
    with JournalReader.open(run) as reader:
        return read_record(reader)


def test_what_every_kind_is_refused_it_is_refused_too(tmp_path: Path) -> None:
    procedure = read_procedure(_file(tmp_path, "[lean]\npitch_deg = 183.0\nby_deg = 5.0"))
    with pytest.raises(
        PlanError, match=r"procedure\.toml:6: lean\.pitch_deg: point 3 asks for pitch 188°.*nearest 185°"
    ):
        make_plan(read_rig(EXAMPLE), procedure)


def test_its_table_is_its_own(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"lean: is missing; this is a procedure of kind 'leaning'"):
        read_procedure(_file(tmp_path, ""))
    both = "[lean]\npitch_deg = 1.0\nby_deg = 5.0\n[static]"
    with pytest.raises(DescriptionError, match=r"procedure\.toml:\d+: lean: belongs to procedure\.kind = 'leaning'"):
        read_procedure(_file(tmp_path, both, kind="static"))
    with pytest.raises(DescriptionError, match=r"procedure\.kind: got 'leanin'.*leaning"):
        read_procedure(_file(tmp_path, "", kind="leanin"))
