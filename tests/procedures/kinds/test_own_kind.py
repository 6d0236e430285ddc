"""A kind of run that is no part of the package is read, refused, planned, foretold and stored (examples/own_kind)."""

from pathlib import Path

import pytest
from installed_examples import install_example

from procedures.check.check_report import check, to_document
from procedures.errors import PlanError
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from rig.description.read import read_rig
from rig.errors import DescriptionError

EXAMPLE = Path(__file__).parents[3] / "examples" / "servo-mechanism" / "rig.toml"


@pytest.fixture(autouse=True)
def _installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install_example("own_kind", tmp_path / "site", monkeypatch)


def _file(folder: Path, table: str, kind: str = "leaning") -> Path:
    path = folder / "procedure.toml"
    text = f'[procedure]\ntitle = "t"\nkind = "{kind}"\nreplications = 2\n{table}\n[solve]\nmodel = "linear"\n'
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
