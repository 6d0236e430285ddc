"""`calrig export` and `calrig verify`: every format there and back, what it loses, and what is refused how."""

import os
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest
from case_shares import rest_to_thorough
from changed_sets import write_changed
from command import call
from foreign_sets import hostile, warm
from not_usable import set_not_usable, set_usable
from solved import provenance, solved_package

from ams.archive.sets import publish
from ams.archive.signatures import sign
from ams.exports.formats import FORMATS, load_set
from ams.sets.canonical import render
from ams.sets.coefficients import CoefficientSet, build_set
from procedures.description.procedure_file import Export

SCHEMAS = os.environ.get("CALRIG_DCC_SCHEMAS")
LOSSY = {"c-fixed", "epics", "imucal", "linear"}


def written(folder: Path, coefficients: CoefficientSet | None = None) -> Path:
    path = folder / "SN1047.json"
    path.write_bytes(render((coefficients or build_set(solved_package(), provenance())).document))
    return path


def test_procedures_and_the_command_know_the_same_formats() -> None:
    assert Export(formats=tuple(FORMATS)).formats == tuple(FORMATS)
    with pytest.raises(ValueError, match=f"allowed are {', '.join(FORMATS)}"):
        Export(formats=("fortran",))


@pytest.mark.parametrize(("make", "verdict"), [(set_usable, "sound"), (set_not_usable, "not usable")])
def test_an_intact_file_of_a_calibration_that_is_not_usable_is_said_to_be_one(
    make: Callable[[], CoefficientSet], verdict: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    header = tmp_path / "sn1047.h"
    assert call(capsys, "export", written(tmp_path, make()), "--to", "c", "--out", header).status == 0
    done = call(capsys, "verify", header)
    assert done.status == 0
    assert ("says that it is not usable" in " ".join(done.out.split())) == (verdict == "not usable")
    assert call(capsys, "verify", header, "--json").document["verdict"] == verdict


@pytest.mark.parametrize("name", rest_to_thorough(sorted(set(FORMATS) - {"json"}), every=3))
def test_every_format_goes_there_and_back_to_the_same_bytes(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    original = written(tmp_path)
    outcome = call(capsys, "export", original, "--to", name, "--json")
    assert outcome.status == 0
    exported = Path(outcome.document["file"])
    assert exported.name == FORMATS[name].file_name("SN1047")
    assert (outcome.document["loses"] is not None) == (name in LOSSY)
    assert call(capsys, "verify", exported).status == 0
    assert call(capsys, "export", exported, "--to", "json", "--out", tmp_path / "back.json").status == 0
    assert (tmp_path / "back.json").read_bytes() == original.read_bytes()


@pytest.mark.parametrize("name", sorted(LOSSY))
def test_a_lossy_format_says_what_it_loses(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "export", written(tmp_path), "--to", name).out
    assert f"The format loses: {FORMATS[name].loses}." in " ".join(outcome.split())


def test_an_unknown_format_is_refused_with_those_there_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "export", written(tmp_path), "--to", "fortran")
    assert outcome.status == 2
    assert (
        "unknown format: got 'fortran', allowed are c, c-fixed, csv, dcc, epics, hdf5, imucal, json, linear"
        in outcome.err
    )
    assert [path.name for path in tmp_path.iterdir()] == ["SN1047.json"]


def test_a_name_of_another_format_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "export", written(tmp_path), "--to", "c", "--out", tmp_path / "a.fixed.h")
    assert outcome.status == 2
    assert "needed .h" in outcome.err
    assert not (tmp_path / "a.fixed.h").exists()


def test_a_set_that_a_format_has_no_form_of_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "export", written(tmp_path, warm()), "--to", "c-fixed")
    assert outcome.status == 2
    assert "got temperature terms" in outcome.err
    assert [path.name for path in tmp_path.iterdir()] == ["SN1047.json"]


@pytest.mark.parametrize("name", rest_to_thorough(FORMATS, every=3))
def test_a_damaged_file_ends_with_2_and_contradicting_vectors_with_1(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    coefficients = build_set(solved_package(), provenance())
    content = FORMATS[name].to_bytes(coefficients)
    path = tmp_path / FORMATS[name].file_name("SN1047")
    path.write_bytes(content[:-100] + bytes([content[-100] ^ 1]) + content[-99:])
    assert call(capsys, "verify", path).status == 2
    contradicting = write_changed(
        tmp_path / "c.json", coefficients, lambda d: d["axes"]["x"]["primary"]["values"].update(offset_v=0.006)
    )
    path.write_bytes(FORMATS[name].to_bytes(load_set(contradicting)))
    outcome = call(capsys, "verify", path)
    assert outcome.status == 1
    assert "axis x" in outcome.err


def test_a_certificate_says_whether_the_official_schemas_were_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "SN1047.xml"
    path.write_bytes(FORMATS["dcc"].to_bytes(hostile()))
    monkeypatch.delenv("CALRIG_DCC_SCHEMAS", raising=False)
    assert "not validated against the official schemas" in " ".join(call(capsys, "verify", path).out.split())
    monkeypatch.setenv("CALRIG_DCC_SCHEMAS", str(tmp_path))
    refused = call(capsys, "verify", path)
    assert refused.status == 2
    assert "the DCC schemas cannot be read" in refused.err
    if SCHEMAS:
        monkeypatch.setenv("CALRIG_DCC_SCHEMAS", SCHEMAS)
        assert "valid by the official schema dcc_3_2_1.xsd" in call(capsys, "verify", path).out


def test_an_export_from_the_archive_names_who_approved_it_and_one_of_the_file_does_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    original = build_set(solved_package(), provenance())
    moment = datetime(2026, 3, 1, 12, tzinfo=UTC)
    publish(url, [original], moment)
    for role, name in (("prepared", "A. Operator"), ("reviewed", "C. Reader"), ("approved", "D. Head")):
        sign(url, "SN1047", role, name, moment)  # type: ignore[arg-type]
    target, file = tmp_path / "SN1047.xml", written(tmp_path, original)
    assert call(capsys, "archive", "export", "SN1047", "--archive", url, "--to", "dcc", "--out", target).status == 0
    assert b"D. Head" in target.read_bytes()
    assert call(capsys, "export", file, "--to", "dcc", "--out", tmp_path / "file.xml").status == 0
    assert b"D. Head" not in (tmp_path / "file.xml").read_bytes()
    assert call(capsys, "verify", target).status == 0
    back = tmp_path / "back.json"
    assert (
        call(capsys, "archive", "export", original.sha256[:8], "--archive", url, "--to", "json", "--out", back).status
        == 0
    )
    assert back.read_bytes() == file.read_bytes()  # what was sealed


def test_an_export_of_what_the_archive_has_not_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url, target = f"sqlite:///{tmp_path / 'archive.sqlite'}", tmp_path / "SN2.json"
    publish(url, [build_set(solved_package(), provenance())], datetime(2026, 3, 1, tzinfo=UTC))
    outcome = call(capsys, "archive", "export", "SN2", "--archive", url, "--to", "json", "--out", target)
    assert outcome.status == 2
    assert "SN2" in outcome.err
    assert not target.exists()
