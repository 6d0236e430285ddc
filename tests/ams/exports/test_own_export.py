"""An export that is no part of the package goes through the command as the package's own do (examples/own_export)."""

from pathlib import Path

import pytest
from command import call
from example_files import EXAMPLE_PROCEDURE, changed
from installed_examples import install_example
from solved import provenance, solved_package

from ams.exports.formats import load_set
from ams.sets.canonical import render
from ams.sets.coefficients import build_set
from procedures.kinds.read import read_procedure
from rig.errors import DescriptionError


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return install_example("own_export", tmp_path / "site", monkeypatch)


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "SN1047.json"
    path.write_bytes(render(build_set(solved_package(), provenance()).document))
    return path


def procedure_with(name: str, folder: Path) -> Path:
    return changed(EXAMPLE_PROCEDURE, '"mat"', f'"{name}"', folder / "procedure.toml")


def test_before_it_is_installed_nobody_knows_it(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="got 'ini': allowed are c, c-fixed, csv, dcc"):
        read_procedure(procedure_with("ini", tmp_path))


@pytest.mark.usefixtures("installed")
def test_a_procedure_and_the_command_know_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "ini" in read_procedure(procedure_with("ini", tmp_path)).export.formats
    assert "parquet, ini;" in call(capsys, "export", "x.json", "--to", "fortran").err


@pytest.mark.usefixtures("installed")
def test_the_command_takes_a_set_there_and_back(written: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "export", written, "--to", "ini")
    assert outcome.status == 0
    assert "The format loses: holds b and k alone" in " ".join(outcome.out.split())
    path = written.with_suffix(".ini")
    assert call(capsys, "verify", path).status == 0
    assert load_set(path).document == load_set(written).document


@pytest.mark.usefixtures("installed")
def test_a_damaged_file_is_refused(written: Path, capsys: pytest.CaptureFixture[str]) -> None:
    call(capsys, "export", written, "--to", "ini")
    path = written.with_suffix(".ini")
    path.write_bytes(path.read_bytes().replace(b"offset_v=", b"offset_v=1", 1))
    outcome = call(capsys, "verify", path)
    assert outcome.status == 2
    assert "checksum: does not fit the content" in outcome.err
