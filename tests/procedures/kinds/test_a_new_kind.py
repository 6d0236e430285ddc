"""A kind of run that is one object: read, refused, planned, foretold and stored without anything else being touched."""

from pathlib import Path

import pytest

from procedures.check.check_report import check, to_document
from procedures.errors import PlanError
from procedures.kinds import registry
from procedures.kinds.kind import Key, Kind, PlanRequest
from procedures.kinds.planner import make_plan
from procedures.kinds.points import PointKind
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from procedures.plan.points import Point
from procedures.plan.steps import Rest
from procedures.solution.by_model import observed, solve_by_model
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.device_settings import Positive
from rig.description.read import read_rig
from rig.errors import DescriptionError
from rig.toml_file import StrictTable

EXAMPLE = Path(__file__).parents[3] / "examples" / "servo-mechanism" / "rig.toml"


class Lean(StrictTable):
    """``[lean]``: three pitches around one."""

    pitch_deg: float
    by_deg: Positive


class Leaning(PointKind):
    """Rest a little before, at and behind one pitch."""

    name = "leaning"
    table: tuple[str, type[StrictTable]] | None = ("lean", Lean)
    models: tuple[str, ...] = ("linear",)

    def measures(self, model: str) -> tuple[str, ...]:
        return ("acceleration",)

    def key_of_angle(self, axis: str) -> Key:
        return "lean", f"{axis}_deg"

    def points(self, request: PlanRequest) -> list[Point]:
        lean = request.procedure.own(Lean)
        assert lean is not None
        pitches = (lean.pitch_deg - lean.by_deg, lean.pitch_deg, lean.pitch_deg + lean.by_deg)
        return [({"pitch": pitch}, Rest(10.0), None) for pitch in pitches]

    def solve(self, item: SensorRows) -> SolvedSensor:
        return solve_by_model(item, observed(item))


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    kind: Kind = Leaning()
    monkeypatch.setitem(registry.KINDS, kind.name, kind)  # type: ignore[arg-type]  # a dictionary, though not to others


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
