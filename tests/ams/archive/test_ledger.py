"""Whatever is changed behind the record's back shows, in both databases; signatures keep their order and four eyes."""

import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from shutil import copyfile
from typing import Any

import pytest
from archived_runs import a_run, a_sensor

from ams.archive.runs import publish_run
from ams.archive.sets import show
from ams.archive.sign_offs import Certificate
from ams.archive.signatures import certificate_of, issue_certificate, sign, sign_off, verify_archive
from ams.errors import ArchiveError, ArchiveUnknown, SetError

NOW = datetime(2026, 6, 1, tzinfo=UTC)
FILE = "ab" * 32


def _fill(url: str) -> None:
    publish_run(url, a_run(0), [a_sensor(0)], NOW)
    for minutes, (role, name) in enumerate((("prepared", "A. Ray"), ("reviewed", "B. Soo"), ("approved", "C. Lim"))):
        sign(url, "SN1", role, name, NOW + timedelta(minutes=minutes))
    issue_certificate(url, "SN1", Certificate("26-001", "", FILE, "C. Lim", NOW, None, ""))


@pytest.fixture(scope="module")
def filled_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Filled once: tests change copies of it."""
    path = tmp_path_factory.mktemp("filled") / "archive.sqlite"
    _fill(f"sqlite:///{path}")
    return path


@pytest.fixture
def filled(archive: Any, request: pytest.FixtureRequest) -> str:
    """One run in the archive, signed and certified; returns the checksum of its set."""
    if archive.is_sqlite:
        made: Path = request.getfixturevalue("filled_file")
        for part in made.parent.iterdir():
            copyfile(part, Path(archive.url.removeprefix("sqlite:///")).with_name(part.name))
    else:
        _fill(archive.url)
    return a_sensor(0).coefficients.sha256


@pytest.mark.parametrize(
    ("statement", "fault"),
    [
        ("UPDATE sets SET document = replace(document, 'survey', 'guess')", "sets .*: is not as it was written"),
        ("UPDATE coefficients SET value = value + 1e-15 WHERE axis = 'x' AND name = 'offset_v'", "is not as it was"),
        ("UPDATE points SET check_sensor = NOT check_sensor", "points .*: is not as it was written"),
        ("UPDATE runs SET operator = 'nobody'", "runs .*: is not as it was written"),
        ("UPDATE standards SET due = '2030-01-01'", "standards AA-2216 26-0117: is not as it was written"),
        ("UPDATE adjustments SET as_left = 'fail'", "adjustments .*: is not as it was written"),
        ("UPDATE signatures SET name = 'D. Nye' WHERE role = 'approved'", "signatures 3: is not as it was written"),
        ("UPDATE certificates SET number = '26-002'", "certificates 26-002: no record tells of this row"),
        ("DELETE FROM certificates", "certificates 26-001: was written and is not there any more"),
        ("DELETE FROM uses", "uses .*: was written and is not there any more"),
        (
            "UPDATE records SET detail = replace(detail, 'C. Lim', 'D. Nye') WHERE sequence = 6",
            r"record 6 \(signature\)",
        ),
        ("UPDATE records SET utc = '2020-01-01 00:00:00' WHERE sequence = 2", r"record 2 \(sets\): is not as it was"),
        ("DELETE FROM records WHERE sequence = 4", "record 4: is missing"),
        ("INSERT INTO standards VALUES ('1', '2', 'meter', NULL, '{}')", "standards 1 2: no record tells of this row"),
    ],
)
def test_a_change_behind_the_record_shows(archive: Any, filled: str, statement: str, fault: str) -> None:
    assert verify_archive(archive.url).faults == ()
    archive.execute(statement)
    faults = verify_archive(archive.url).faults
    assert any(re.search(fault, one) for one in faults), faults


def test_the_head_stands_for_everything_and_moves_with_every_write(archive: Any, filled: str) -> None:
    before = verify_archive(archive.url).head
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    assert verify_archive(archive.url).head == before
    publish_run(archive.url, a_run(1), [a_sensor(1)], NOW)
    assert verify_archive(archive.url).head.sequence == before.sequence + 3


def test_a_set_filed_under_another_checksum_is_not_handed_out(archive: Any, filled: str) -> None:
    first = filled
    publish_run(archive.url, a_run(1), [a_sensor(1)], NOW)
    archive.execute(
        f"UPDATE sets SET document = (SELECT document FROM sets WHERE sha256 <> '{first}') WHERE sha256 = '{first}'"
    )
    with pytest.raises(SetError, match="holds another set"):
        show(archive.url, first)


def test_signatures_come_in_their_order_and_not_all_from_one_hand(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    url = archive.url
    assert sign_off(url, "SN1").state == "unsigned"
    with pytest.raises(ArchiveError, match="approved: is not its turn: the set is unsigned, prepared comes next"):
        sign(url, "SN1", "approved", "C. Lim", NOW)
    sign(url, "SN1", "prepared", "A. Ray", NOW, "second replication looked at")
    with pytest.raises(ArchiveError, match=r"a\.  ray prepared this set; nothing was signed; somebody else must"):
        sign(url, "SN1", "reviewed", " a.  ray", NOW)
    sign(url, "SN1", "reviewed", "B. Soo", NOW)
    with pytest.raises(ArchiveError, match=r"A\. Ray prepared this set"):
        sign(url, "SN1", "approved", "A. Ray", NOW)
    assert not sign_off(url, "SN1").approver_reviewed
    signed = sign(url, "SN1", "approved", "b. soo", NOW)
    assert (signed.is_approved, signed.approver_reviewed) == (True, True)
    with pytest.raises(ArchiveError, match="it is approved already"):
        sign(url, "SN1", "approved", "C. Lim", NOW)
    found = sign_off(url, "SN1").by("prepared")
    assert found is not None
    assert (found.name, found.comment, found.signed_utc) == ("A. Ray", "second replication looked at", NOW)
    with pytest.raises(
        ArchiveUnknown, match="role: got 'blessed', allowed are prepared, reviewed, approved, withdrawn"
    ):
        sign(url, "SN1", "blessed", "C. Lim", NOW)
    with pytest.raises(ArchiveError, match="needs a name"):
        sign(url, "SN1", "withdrawn", " ", NOW)


def test_a_withdrawn_set_stays_withdrawn_and_needs_a_reason(archive: Any, filled: str) -> None:
    with pytest.raises(ArchiveError, match="withdrawn: needs a reason"):
        sign(archive.url, "SN1", "withdrawn", "C. Lim", NOW)
    assert sign(archive.url, "SN1", "withdrawn", "C. Lim", NOW, "wrong mount").state == "withdrawn"
    with pytest.raises(ArchiveError, match="the set is withdrawn; nothing was signed"):
        sign(archive.url, "SN1", "prepared", "A. Ray", NOW)
    with pytest.raises(ArchiveError, match="is withdrawn, needed is approved"):
        issue_certificate(archive.url, "SN1", Certificate("26-009", "", FILE, "C. Lim", NOW, None, ""))


def test_a_certificate_needs_an_approved_set_and_a_number_of_its_own(archive: Any, filled: str) -> None:
    publish_run(archive.url, a_run(1), [a_sensor(1, "SN2")], NOW)
    with pytest.raises(ArchiveError, match="is unsigned, needed is approved; nothing was issued; have it signed first"):
        issue_certificate(archive.url, "SN2", Certificate("26-001", "", FILE, "C. Lim", NOW, None, ""))
    sha256 = filled
    again = issue_certificate(archive.url, "SN1", Certificate("26-001", "", FILE, "C. Lim", NOW, None, ""))
    assert [certificate.number for certificate in again.certificates] == ["26-001"]
    with pytest.raises(ArchiveError, match="26-001: is issued already"):
        issue_certificate(archive.url, "SN1", Certificate("26-001", "", "cd" * 32, "C. Lim", NOW, None, ""))
    with pytest.raises(ArchiveUnknown, match="amends 25-900, which is not in the archive"):
        issue_certificate(archive.url, "SN1", Certificate("26-002", "", FILE, "C. Lim", NOW, "25-900", "typing error"))
    with pytest.raises(ArchiveError, match="amends 26-001 and gives no reason"):
        issue_certificate(archive.url, "SN1", Certificate("26-002", "", FILE, "C. Lim", NOW, "26-001", ""))
    issue_certificate(archive.url, "SN1", Certificate("26-002", "", FILE, "C. Lim", NOW, "26-001", "customer's name"))
    found = certificate_of(archive.url, "26-002")
    assert found is not None
    assert (found.sha256, found.amends, found.reason) == (sha256, "26-001", "customer's name")


def test_signing_in_an_archive_that_is_not_there_makes_none(tmp_path: Any) -> None:
    with pytest.raises(ArchiveUnknown, match="there is no archive: no such file; nothing was changed"):
        sign(f"sqlite:///{tmp_path / 'none.sqlite'}", "SN1", "prepared", "A. Ray", NOW)
    assert not (tmp_path / "none.sqlite").exists()
