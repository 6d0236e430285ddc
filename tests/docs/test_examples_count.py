"""What a new model, driver, export, design, section and kind of run costs: its own files and one registration."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ALLOWED = {
    "own_model": ("calrig.models", 1),
    "own_driver": ("calrig.drivers", 4),  # codec, device, twin, and what brings them together
    "own_meter": ("calrig.drivers", 3),  # device, twin, and what brings them together; SCPI has its codec
    "own_axis": ("calrig.drivers", 4),  # the same, to angles and at rates
    "own_stream": ("calrig.drivers", 4),
    "own_field": ("calrig.drivers", 3),
    "own_export": ("calrig.exports", 1),
    "own_design": ("calrig.designs", 1),
    "own_observer": ("calrig.observers", 1),
    "own_line_output": ("calrig.observers", 1),
    "own_section": ("calrig.sections", 1),
    "own_kind": ("calrig.kinds", 1),
}


@pytest.mark.parametrize("name", ALLOWED)
def test_an_example_is_its_own_files_and_one_registration(name: str) -> None:
    group, files = ALLOWED[name]
    folder = ROOT / "examples" / name
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert list(project["entry-points"]) == [group]
    assert len(project["entry-points"][group]) == 1
    assert len([path for path in folder.rglob("*.py") if "__pycache__" not in path.parts]) == files


@pytest.mark.parametrize("name", ALLOWED)
def test_nothing_of_calrig_knows_an_example(name: str) -> None:
    """What an example registers is imported nowhere in the three packages: nothing there was written for it."""
    entries = tomllib.loads((ROOT / "examples" / name / "pyproject.toml").read_text("utf-8"))["project"]["entry-points"]
    [target] = [target for group in entries.values() for target in group.values()]
    module = target.partition(":")[0]
    sources = [path for package in ("ams", "rig", "procedures") for path in (ROOT / package).rglob("*.py")]
    assert [path for path in sources if re.search(rf"(?m)^\s*(from|import) {module}\b", path.read_text("utf-8"))] == []


def test_every_group_of_calrig_has_an_example() -> None:
    own = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    assert set(own) == {group for group, _ in ALLOWED.values()}
