"""A calibration that is not usable: nobody approves it in passing, and whoever did is named wherever the set goes."""

import re
import subprocess
from datetime import UTC, datetime
from html import unescape
from pathlib import Path

import pytest
from certificate_scene import set_with_findings
from command import call
from not_usable import FINDING, REASON, STANDING, accept_findings, approve_not_usable, set_not_usable, set_usable
from programs import require_program
from signers import with_accounts

from ams.archive.sets import list_sets, publish, show
from ams.archive.sign_offs import Certificate
from ams.archive.signatures import accept, issue_certificate, sign, sign_off, verify_archive
from ams.errors import ArchiveForbids, ArchiveUnknown
from ams.exports.formats import FORMATS, export_set
from ams.exports.verify import verify
from procedures.certificate.grounds import gaps_of
from procedures.certificate.issue import GroundsOf, issue
from procedures.errors import RequestError

MOMENT = datetime(2026, 3, 2, 9, tzinfo=UTC)
OF_THE_DOCUMENT_ALONE = {"json", "csv", "hdf5", "mat", "parquet"}
"""These hold the sealed set, with its verdict, and nothing that became of it since."""


@pytest.fixture
def archive(tmp_path: Path) -> str:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish(url, [set_not_usable(approved_by=None)], MOMENT)
    return url


@pytest.fixture
def approved(archive: str) -> str:
    approve_not_usable(archive, MOMENT)
    return archive


def test_accepting_every_finding_accepts_no_verdict(archive: str) -> None:
    accept_findings(archive, MOMENT)
    with pytest.raises(ArchiveForbids, match=r"nobody has accepted the verdict 'not usable' .*; nothing was signed; "):
        sign(archive, "SN1047", "approved", "B. Chief", MOMENT)
    with pytest.raises(ArchiveForbids, match=r"accept not usable: A\. Operator prepared this set"):
        accept(archive, "SN1047", "not usable", "A. Operator", MOMENT, REASON)
    with pytest.raises(ArchiveForbids, match="accept not usable: needs a reason"):
        accept(archive, "SN1047", "not usable", "C. Reader", MOMENT, " ")
    signed = accept(archive, "SN1047", "not usable", "C. Reader", MOMENT, REASON)
    assert [word.finding for word in signed.acceptances] == [FINDING]
    with pytest.raises(ArchiveForbids, match=r"C\. Reader accepted it already"):
        accept(archive, "SN1047", "not usable", "B. Chief", MOMENT, REASON)
    assert signed.standing == "reviewed", "an acceptance approves nothing"
    assert sign(archive, "SN1047", "approved", "B. Chief", MOMENT).standing == STANDING
    assert verify_archive(archive).faults == ()


def test_a_verdict_that_needs_no_acceptance_takes_none(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish(url, [set_with_findings()], MOMENT)
    sign(url, "SN1047", "prepared", "A. Operator", MOMENT)
    with pytest.raises(ArchiveUnknown, match=r"accept not usable: the calibration of the set is not that: its verdict"):
        accept(url, "SN1047", "not usable", "C. Reader", MOMENT, REASON)


def test_the_verdict_is_a_gap_of_the_certificate_until_it_is_accepted_by_its_own_name(
    archive: str, tmp_path: Path
) -> None:
    accept_findings(archive, MOMENT)
    grounds = GroundsOf("7", MOMENT).complete(archive, "SN1047")
    (gap,) = (gap for gap in gaps_of(grounds) if "not usable" in gap)
    assert "calibrate again, or have the verdict accepted by name, with a reason (calrig archive accept" in gap
    with pytest.raises(RequestError, match=re.escape(gap)):
        issue(archive, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    accept(archive, "SN1047", "not usable", "C. Reader", MOMENT, REASON)
    sign(archive, "SN1047", "approved", "B. Chief", MOMENT)
    assert not list(gaps_of(GroundsOf("7", MOMENT).complete(archive, "SN1047")))


def test_an_approval_of_before_that_says_nothing_of_the_verdict_carries_no_certificate(
    archive: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As archives have it whose sets were approved when accepted findings were enough."""
    accept_findings(archive, MOMENT)
    with monkeypatch.context() as before:
        before.setattr("ams.archive.signatures._check_nothing_open", lambda *_: None)
        sign(archive, "SN1047", "approved", "B. Chief", MOMENT)
    assert show(archive, "SN1047").standing == "approved though not usable, accepted by nobody"
    with pytest.raises(ArchiveForbids, match="certificate 7: nobody has accepted the verdict"):
        issue_certificate(archive, "SN1047", Certificate("7", "", "0" * 64, "B. Chief", MOMENT, None, ""))
    with pytest.raises(RequestError, match="nobody has accepted the verdict"):
        issue(archive, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    accept(archive, "SN1047", "not usable", "C. Reader", MOMENT, REASON)
    assert show(archive, "SN1047").standing == STANDING


def test_a_set_of_before_the_verdict_tells_it_by_its_finding(archive: str) -> None:
    entry = show(archive, "SN1047")
    document = {name: value for name, value in entry.document.items() if name != "verdict"}
    assert type(entry)(document, entry.axes, entry.validity).verdict == "not usable"


def test_a_list_tells_the_verdict_of_every_set_before_anybody_signed(
    archive: str, capsys: pytest.CaptureFixture[str]
) -> None:
    publish(archive, [set_usable()], MOMENT)
    lines = call(capsys, "archive", "list", "--archive", archive).out.splitlines()[1:]
    told = {entry.sha256: entry.verdict for entry in list_sets(archive)}
    assert told == {sha256: show(archive, sha256).verdict for sha256 in told}
    assert len(lines) == len(told) == len(set(told.values())) == 2
    assert all(line.endswith(f", verdict {told[sha256]}") for line in lines for sha256 in told if line[:12] in sha256)
    assert sum("engineering, verdict not usable" in line for line in lines) == 1


def test_the_same_words_stand_in_archive_and_certificate(
    approved: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = issue(approved, "SN1047", GroundsOf("7", MOMENT), "B. Chief", tmp_path)
    page = re.sub(r"<style>.*?</style>", "", done.page.read_text(encoding="utf-8"), flags=re.DOTALL)
    text = " ".join(unescape(re.sub(r"<[^>]+>", " ", page)).split())
    assert text.count(f"The set is {STANDING}.") == 2, "at the head and beside the verdict"
    paper = subprocess.run([require_program("pdftotext"), "-layout", done.paper, "-"], capture_output=True, check=True)
    pages = paper.stdout.decode("utf-8").rstrip("\f").split("\f")
    assert all("CALIBRATION NOT USABLE" in single for single in pages), "on every page"
    assert re.sub(r"\s", "", STANDING) in re.sub(r"\s", "", "".join(pages))
    shown = call(capsys, "archive", "show", "SN1047", "--archive", approved).out
    assert f"pitch-roll (TP), {STANDING}" in shown
    assert f"set {sign_off(approved, 'SN1047').sha256[:12]}: {STANDING}" in shown
    assert "  verdict    not usable: accepted by C. Reader, " in shown
    assert STANDING in call(capsys, "archive", "list", "--archive", approved).out
    assert list_sets(approved)[0].standing == STANDING
    (listed,) = call(capsys, "archive", "list", "--json", "--archive", approved).document["sets"]
    assert listed["standing"] == STANDING


@pytest.mark.parametrize("name", sorted(FORMATS))
def test_the_same_words_stand_in_every_export_and_it_verifies(name: str, approved: str, tmp_path: Path) -> None:
    entry, form = show(approved, "SN1047"), FORMATS[name]
    path = tmp_path / form.file_name("SN1047")
    export_set(entry, name, path)
    text = path.read_bytes().decode("utf-8", "replace")
    plain = re.sub(r"\s+", " ", re.sub(r"\n\s*(\*|#|//|%)?\s*", " ", text))
    assert (re.sub(r"\s", "", STANDING) in re.sub(r"\s", "", plain)) == (name not in OF_THE_DOCUMENT_ALONE)
    assert verify(path).sha256 == entry.sha256


def test_the_command_says_what_to_do_and_takes_the_verdict_by_its_name(
    archive: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    accept_findings(archive, MOMENT)
    secret = with_accounts(tmp_path, monkeypatch, "B. Chief", "C. Reader")
    where = ("--archive", archive, *secret)
    refused = call(capsys, "archive", "sign", "SN1047", "approved", "--operator", "B. Chief", *where)
    assert (refused.status, "archive accept" in refused.err) == (2, True)
    word = ("accept", "SN1047", "not usable", "--operator", "C. Reader", "--reason", REASON)
    assert "verdict    not usable: accepted by C. Reader" in call(capsys, "archive", *word, *where).out
    signed = call(capsys, "archive", "sign", "SN1047", "approved", "--operator", "B. Chief", "--json", *where).document
    assert (signed["state"], signed["standing"], signed["verdict"]) == ("approved", STANDING, "not usable")


def test_an_approved_rig_approves_no_set_that_is_not_usable(tmp_path: Path) -> None:
    """Of one that nobody signed: the same in the set, its exports and the archive."""
    entry, url = set_not_usable(approved_by="B. Chief"), f"sqlite:///{tmp_path / 'a.sqlite'}"
    publish(url, [entry], MOMENT)
    listed = list_sets(url)[0]
    assert (entry.document["status"], entry.document["approved_by"]) == ("engineering", "B. Chief")
    assert (entry.status, entry.standing, entry.approved_by) == ("engineering", "engineering", None)
    assert (listed.status, listed.standing, show(url, "SN1047").standing) == ("engineering",) * 3
    export_set(entry, "c", tmp_path / "set.h")
    assert "; status: engineering" in (tmp_path / "set.h").read_text(encoding="utf-8")
    assert verify(tmp_path / "set.h").standing == "engineering"
