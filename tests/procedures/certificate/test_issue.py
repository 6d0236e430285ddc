"""Issued once, entered once: what the archive knows and what lies on the disk are the same file."""

import hashlib
import json
import re
from datetime import UTC, datetime
from pathlib import Path

import pikepdf
import pytest
from certificate_scene import RELEASED, set_with_findings
from signers import with_accounts
from solved import provenance, solved_package

from ams.archive.sets import list_sets, publish, show
from ams.archive.signatures import certificate_of, sign, verify_archive
from ams.errors import ArchiveError, ArchiveForbids, WriteFailed
from ams.exports.dcc import from_dcc, to_dcc
from ams.sets.coefficients import build_set
from procedures.certificate.issue import GroundsOf, issue
from procedures.cli.main import run_command
from procedures.errors import RequestError

MOMENT = datetime(2026, 3, 2, 9, tzinfo=UTC)


@pytest.fixture
def archive(tmp_path: Path) -> str:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish(url, [build_set(solved_package(), provenance(**RELEASED))], MOMENT)
    return url


@pytest.fixture
def approved(archive: str) -> str:
    for role, name in (("prepared", "A. Operator"), ("reviewed", "C. Reader"), ("approved", "B. Chief")):
        sign(archive, "SN1047", role, name, MOMENT)
    return archive


def test_the_archive_knows_the_very_file_that_was_written(approved: str, tmp_path: Path) -> None:
    done = issue(approved, "SN1047", GroundsOf("2026/0117", MOMENT), "B. Chief", tmp_path)
    assert done.paper.name == "certificate-2026-0117.pdf"
    entry = certificate_of(approved, "2026/0117")
    assert entry is not None
    assert entry.file_sha256 == hashlib.sha256(done.paper.read_bytes()).hexdigest()
    assert entry.issued_by == "B. Chief"
    assert verify_archive(approved).faults == ()


def test_the_attached_certificate_for_machines_holds_the_same_set_and_says_who_approved_it(
    approved: str, tmp_path: Path
) -> None:
    done = issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    dcc = _attached(done.paper)["SN1047.xml"]
    assert from_dcc(dcc, "attachment").sha256 == done.grounds.coefficients.sha256
    assert b"nobody has approved" not in dcc


def test_whoever_authorises_is_identified_by_name_and_function(
    archive: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """ISO/IEC 17025, 7.8.2.1 o), on the page, in the PDF's certificate for machines, and in the archive."""
    secret = with_accounts(tmp_path, monkeypatch, "A. Operator", "B. Chief", "C. Reader")
    told = {
        "prepared": ("A. Operator", ""),
        "reviewed": ("C. Reader", "deputy"),
        "approved": ("B. Chief", "head of lab"),
    }
    for role, (name, function) in told.items():
        words = ["--operator", name, *secret, *(["--function", function] if function else [])]
        assert run_command(["archive", "sign", "SN1047", role, *words, "--archive", archive]) == 0
    shown = capsys.readouterr().out
    assert "approved   B. Chief, head of lab, " in shown
    assert "prepared   A. Operator, 20" in shown
    done = issue(archive, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    page = done.page.read_text(encoding="utf-8")
    assert "Approved: B. Chief, head of lab<br>" in page
    assert "Reviewed: C. Reader, deputy<br>" in page
    assert "Prepared: A. Operator<br>" in page
    dcc = _attached(done.paper)["SN1047.xml"]
    for role in ("prepared", "reviewed, deputy", "approved, head of lab"):
        assert f"<dcc:role>{role}</dcc:role>".encode() in dcc
    assert dcc.count(b"<dcc:mainSigner>true</dcc:mainSigner>") == 1
    with pytest.raises(ArchiveForbids, match=r"the function holds U\+202E, which nobody sees"):
        sign(archive, "SN1047", "withdrawn", "B. Chief", MOMENT, "dropped", function="chief\u202e")


def test_a_set_of_engineering_that_signatures_approve_is_a_certificate_and_its_attachments_name_who_approved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish(url, [set_with_findings(approved_by=None)], MOMENT)
    where = ["--archive", url]
    secret = with_accounts(tmp_path, monkeypatch, "A. Operator", "B. Chief", "C. Reader")
    for word in (
        ["sign", "SN1047", "prepared", "--operator", "A. Operator"],
        *(
            ["accept", "SN1047", name, "--operator", "C. Reader", "--reason", "small here"]
            for name in ("y.cubic", "y.wrong-dwell", "y.wrong-dwell.2")
        ),
        ["sign", "SN1047", "reviewed", "--operator", "C. Reader"],
        ["sign", "SN1047", "approved", "--operator", "B. Chief"],
    ):
        assert run_command(["archive", *word, *where, *secret]) == 0, word
    capsys.readouterr()
    assert run_command(["archive", "show", "SN1047", *where]) == 0
    shown = capsys.readouterr().out
    assert "pitch-roll (TP), approved" in shown
    assert "finding    y.cubic: accepted by C. Reader, " in shown
    assert [
        (coefficients.status, show(url, coefficients.sha256).document["status"]) for coefficients in list_sets(url)
    ] == [("approved", "engineering")]
    dcc = to_dcc(show(url, "SN1047"))
    assert b"B. Chief" in dcc
    assert b"engineering: not approved" not in dcc
    done = issue(url, "SN1047", GroundsOf("8", MOMENT), "B. Chief", tmp_path)
    page = " ".join(done.page.read_text(encoding="utf-8").split())
    assert "Accepted by C. Reader" in page
    assert "attached as it was sealed when it was solved: its status and approval are those of that moment" in page
    attached = _attached(done.paper)
    assert b'"approved_by": null' in attached["SN1047.json"]
    assert (
        b"its keys status and approved_by are those of that moment; it was approved since by B. Chief"
        in (attached["SN1047.xml"])
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["accept", "SN1047", "y.cubic", "--operator", "N. N.", "--reason", "small"], "N. N.: nobody of that name has"),
        (["accept", "SN1047", "y.cubic", "--operator", "", "--reason", "small"], "--operator: got '', which is empty"),
        (["accept", "SN1047", "y.cubic", "--operator", "  ", "--reason", "small"], "--operator: got '  ', which is"),
        (["accept", "SN1047", "y.cubic", "--operator", "C.\x07Reader", "--reason", "small"], "holds <U+0007>, which"),
        (["accept", "SN1047", "y.cubic", "--operator", "C. Reader", "--reason", "a\nb"], "holds <U+000A>, a line"),
        (["certificate", "SN1047", "--operator", "", "--number", "7"], "--operator: got '', which is empty"),
        (["accept", "SN1047", "y.cubic", "--operator", "C. Reader"], "accept y.cubic: needs a reason"),
        (["accept", "SN1047", "x.drift", "--operator", "C. Reader", "--reason", "small"],
         "no such finding: its significant findings are y.cubic, y.wrong-dwell, y.wrong-dwell.2"),
        (["release", "SN1047", "--operator", "C. Reader", "--reason", "small"], "the set is not in quarantine"),
    ],
)  # fmt: skip
def test_a_word_without_name_reason_or_object_is_a_sentence(
    arguments: list[str],
    words: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish(url, [set_with_findings()], MOMENT)
    sign(url, "SN1047", "prepared", "A. Operator", MOMENT)
    secret = with_accounts(tmp_path, monkeypatch, "C. Reader")
    command = arguments if arguments[0] == "certificate" else ["archive", *arguments, *secret]
    assert run_command([*command, "--archive", url]) == 2
    assert words in capsys.readouterr().err


def test_issuing_again_is_the_same_file_and_another_content_under_the_number_is_refused(
    approved: str, tmp_path: Path
) -> None:
    first = issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    assert issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path).sha256 == first.sha256
    before = first.paper.read_bytes()
    with pytest.raises(ArchiveError, match="issued already"):
        issue(approved, "SN1047", GroundsOf("7", MOMENT.replace(day=3)), "B. Chief", tmp_path)
    assert first.paper.read_bytes() == before


def test_an_unsigned_set_gets_no_certificate_and_no_file(archive: str, tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="nobody has signed the set as approved"):
        issue(archive, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    assert not list(tmp_path.glob("certificate*"))
    assert certificate_of(archive, "7") is None


def test_a_withdrawn_set_is_not_exported_and_is_shown_as_that_first(
    approved: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sha256 = list_sets(approved)[0].sha256
    sign(approved, "SN1047", "withdrawn", "B. Chief", MOMENT, "dropped on the floor")
    said = "withdrawn by B. Chief on 2026-03-02 (UTC): dropped on the floor"
    for key in ("SN1047", sha256):
        for form in ("c", "json", "csv", "mat", "dcc"):
            out = tmp_path / f"set.{form}"
            assert run_command(["archive", "export", key, "--to", form, "--out", str(out), "--archive", approved]) != 0
            assert said in " ".join(capsys.readouterr().err.split())
            assert not out.exists()
        assert run_command(["archive", "show", key, "--archive", approved]) == 0
        shown = " ".join(capsys.readouterr().out.split())
        assert shown.startswith(f"SN1047: set {sha256[:12]} is {said}: it must not be used")
        assert run_command(["archive", "show", key, "--json", "--archive", approved]) == 0
        assert said in " ".join(capsys.readouterr().err.split())


def test_a_withdrawn_set_gets_no_certificate(approved: str, tmp_path: Path) -> None:
    sign(approved, "SN1047", "withdrawn", "B. Chief", MOMENT, "dropped on the floor")
    said = "the set is withdrawn by B. Chief on 2026-03-02 (UTC): dropped on the floor"
    with pytest.raises(RequestError, match=re.escape(said)):
        issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    assert not list(tmp_path.glob("certificate*"))
    early = datetime(2020, 1, 1, tzinfo=UTC)
    with pytest.raises(RequestError, match=f"(?s)before the calibration.*{re.escape(said)}"):
        issue(approved, "SN1047", GroundsOf("7", early), "B. Chief", tmp_path)
    specimen = issue(approved, "SN1047", GroundsOf("7", MOMENT, is_specimen=True), "B. Chief", tmp_path)
    page = specimen.page.read_text(encoding="utf-8")
    assert page.count(said.removeprefix("the set is ")) == 2  # its stamp, and why it could not be issued
    assert "SET WITHDRAWN" in page
    assert "Withdrawn: B. Chief" in page


def test_an_amendment_is_entered_with_what_it_replaces(approved: str, tmp_path: Path) -> None:
    issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    done = issue(approved, "SN1047", GroundsOf("7-A", MOMENT, "7", "address of the customer"), "B. Chief", tmp_path)
    entry = certificate_of(approved, "7-A")
    assert entry is not None
    assert (entry.amends, entry.reason) == ("7", "address of the customer")
    assert "replaces certificate 7" in re.sub(r"\s+", " ", done.page.read_text(encoding="utf-8"))
    dcc = _attached(done.paper)["SN1047.xml"]
    assert b"<dcc:uniqueIdentifier>7-A</dcc:uniqueIdentifier>" in dcc
    assert b"<dcc:replacedUniqueIdentifier>7</dcc:replacedUniqueIdentifier>" in dcc


def _attached(paper: Path) -> dict[str, bytes]:
    """Return the files inside a PDF by their names."""
    with pikepdf.open(paper) as document:
        return {
            name.split("/")[-1]: document.attachments[name].get_file().read_bytes() for name in document.attachments
        }


def test_a_specimen_leaves_no_trace_in_the_archive(archive: str, tmp_path: Path) -> None:
    done = issue(archive, "SN1047", GroundsOf("7", MOMENT, is_specimen=True), "B. Chief", tmp_path)
    assert done.paper.name == "specimen-7.pdf"
    assert certificate_of(archive, "7") is None


def test_a_folder_that_refuses_is_told(approved: str, tmp_path: Path) -> None:
    (tmp_path / "certificate-7.html").mkdir()
    with pytest.raises(WriteFailed, match=r"certificate-7\.html"):
        issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--issued", "2.3.2026"], "is no day"),
        (["--issued", "2999-01-01"], "which is to come"),
        (["--issued", "2020-01-01"], "before the calibration ended on"),
        (["--amends", "6"], "belong together"),
        (["--out", "no/such/folder"], "is no folder"),
    ],
)
def test_a_wrong_request_is_a_sentence_and_status_2(
    arguments: list[str], words: str, approved: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    text = ["certificate", "SN1047", "--number", "7", "--archive", approved, *arguments]
    assert run_command(text) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.glob("certificate*"))


def test_the_command_issues_and_tells_where(approved: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = ["certificate", "SN1047", "--number", "7", "--operator", "B. Chief", "--issued", "2026-03-03"]
    assert run_command([*text, "--archive", approved, "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["specimen"] is False
    assert (tmp_path / "certificate-7.pdf").exists()
