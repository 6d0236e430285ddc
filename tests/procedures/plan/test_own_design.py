"""A design that is no part of the package goes through the command as the package's own do (examples/own_design)."""

import re
from pathlib import Path

import pytest
from command import call
from example_files import EXAMPLE_PROCEDURE, EXAMPLE_RIG
from installed_examples import install_example


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return install_example("own_design", tmp_path / "site", monkeypatch)


def procedure_with(design: str, folder: Path) -> Path:
    """The example procedure with another table ``[design]``."""
    text = EXAMPLE_PROCEDURE.read_text(encoding="utf-8")
    path = folder / "procedure.toml"
    path.write_text(re.sub(r"(?s)\[design\]\n.*?\n\n", f"[design]\n{design}\n\n", text, count=1), encoding="utf-8")
    return path


def test_before_it_is_installed_nobody_knows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "check", procedure_with('kind = "spiral"', tmp_path), "--rig", EXAMPLE_RIG)
    assert outcome.status == 2
    assert (
        "design.kind: got 'spiral': allowed are D, D0, D1, T, factorial, file, fractional, optimal, up-down"
        in outcome.err
    )


@pytest.mark.usefixtures("installed")
def test_a_procedure_is_planned_with_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = procedure_with('kind = "spiral"\npoints = 40\norder = "raster"', tmp_path)
    outcome = call(capsys, "check", path, "--rig", EXAMPLE_RIG, "--json")
    assert outcome.status == 0, outcome.err
    assert outcome.document["design"] == "spiral"


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("design", "sentence"),
    [
        ('kind = "spiral"\npoints = 3', "procedure.toml:8: design.points: got 3"),
        ('kind = "spiral"\npitch_deg = [0.0]', 'procedure.toml:8: design.pitch_deg: kind = "spiral" has attitudes of'),
        ('kind = "D"\npitch_deg = [0.0, 10.0]\npoints = 9', "design.points: unknown key"),
    ],
)
def test_its_keys_are_checked_like_every_other(
    design: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "check", procedure_with(design, tmp_path), "--rig", EXAMPLE_RIG)
    assert outcome.status == 2
    assert sentence in outcome.err


@pytest.mark.usefixtures("installed")
def test_the_command_judges_it(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "design", "--kind", "spiral", "--json")
    assert outcome.status == 0, outcome.err
    assert outcome.document["points"] == 36
