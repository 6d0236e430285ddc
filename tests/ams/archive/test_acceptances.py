"""What a person answers for after the fact: findings accepted, a quarantine released, an approval on top of both."""

import re
from datetime import UTC, datetime
from typing import Any

import pytest
from archived_runs import a_run, a_sensor, turned
from certificate_scene import set_with_findings

from ams.archive.histories import history
from ams.archive.runs import adjustment_of, publish_run
from ams.archive.sets import list_sets, publish, show
from ams.archive.signatures import accept, release, set_to_use, sign, sign_off, verify_archive
from ams.errors import ArchiveForbids

NOW = datetime(2026, 6, 1, tzinfo=UTC)
FINDINGS = ("y.cubic", "y.wrong-dwell", "y.wrong-dwell.2")


def test_nothing_is_approved_before_somebody_else_accepted_every_significant_finding(archive: Any) -> None:
    url = archive.url
    publish(url, [set_with_findings(approved_by=None)], NOW)
    with pytest.raises(ArchiveForbids, match=r"accept y\.cubic: nobody has prepared the set"):
        accept(url, "SN1047", "y.cubic", "B. Soo", NOW, "small")
    sign(url, "SN1047", "prepared", "A. Ray", NOW)
    sign(url, "SN1047", "reviewed", "B. Soo", NOW)
    with pytest.raises(ArchiveForbids, match=r"A\. Ray prepared this set"):
        accept(url, "SN1047", "y.cubic", "A. Ray", NOW, "small")
    with pytest.raises(ArchiveForbids, match=r"accept y\.cubic: needs a name: got ' '; nothing was signed; say who"):
        accept(url, "SN1047", "y.cubic", " ", NOW, "small")
    accept(url, "SN1047", "y.cubic", "B. Soo", NOW, "3 µg/g³: below the limit of this tunnel")
    with pytest.raises(ArchiveForbids, match=r"nobody has accepted y\.wrong-dwell, y\.wrong-dwell\.2; nothing was"):
        sign(url, "SN1047", "approved", "C. Lim", NOW)
    for name in FINDINGS[1:]:
        accept(url, "SN1047", name, "B. Soo", NOW, "voided since")
    with pytest.raises(ArchiveForbids, match=r"B\. Soo accepted it already"):
        accept(url, "SN1047", "y.cubic", "C. Lim", NOW, "again")
    assert list_sets(url)[0].status == show(url, "SN1047").status == "engineering"
    signed = sign(url, "SN1047", "approved", "C. Lim", NOW)
    assert signed.is_approved
    assert [acceptance.finding for acceptance in signed.acceptances] == list(FINDINGS)
    assert signed.acceptances[0].reason == "3 µg/g³: below the limit of this tunnel"
    assert (list_sets(url)[0].status, show(url, "SN1047").approved_by) == ("approved", "C. Lim")
    assert verify_archive(url).faults == ()
    archive.execute("UPDATE signatures SET comment = 'y.cubic: fine' WHERE role = 'accepted' AND sequence = 3")
    assert any("signatures 3: is not as it was written" in fault for fault in verify_archive(url).faults)


def test_a_set_that_is_withdrawn_after_its_approval_is_not_approved_any_more(archive: Any) -> None:
    publish_run(archive.url, a_run(0), [a_sensor(0)], NOW)
    for role, name in (("prepared", "A. Ray"), ("reviewed", "B. Soo"), ("approved", "C. Lim")):
        sign(archive.url, "SN1", role, name, NOW)
    assert show(archive.url, "SN1").status == "approved"
    sign(archive.url, "SN1", "withdrawn", "C. Lim", NOW, "wrong mount")
    assert (list_sets(archive.url)[0].status, show(archive.url, "SN1").status) == ("withdrawn", "withdrawn")


def test_a_released_set_counts_again_and_its_quarantine_stays_on_record(archive: Any) -> None:
    url = archive.url
    publish_run(url, a_run(0), [a_sensor(0)], NOW)
    publish_run(url, a_run(10), [turned(a_sensor(10))], NOW)
    first, second = (coefficients.sha256 for coefficients in list_sets(url))
    for role, name in (("prepared", "A. Ray"), ("reviewed", "B. Soo")):
        sign(url, second, role, name, NOW)
    with pytest.raises(ArchiveForbids, match=r"is in quarantine .*; nothing was signed; calibrate again, or have"):
        sign(url, second, "approved", "C. Lim", NOW)
    with pytest.raises(ArchiveForbids, match="release: needs a name"):
        release(url, second, " ", NOW, "the clamp")
    with pytest.raises(ArchiveForbids, match="release: needs a reason"):
        release(url, second, "C. Lim", NOW, "")
    assert show(url, "SN1").sha256 == first
    release(url, second, "C. Lim", NOW, "an autocollimator saw no turn")
    with pytest.raises(ArchiveForbids, match=r"C\. Lim released it already"):
        release(url, second, "B. Soo", NOW, "again")
    assert show(url, "SN1").sha256 == second
    assert [coefficients.quarantine for coefficients in list_sets(url)] == [None, None]
    signed = sign_off(url, "SN1")
    assert str(signed.quarantine).startswith("all three sensors turned by −72″")
    assert signed.release is not None
    assert (signed.release.name, signed.release.reason) == ("C. Lim", "an autocollimator saw no turn")
    published = publish_run(url, a_run(20), [a_sensor(20)], NOW)
    found = published.adjustments["SN1"].as_found
    assert found is not None
    assert found.set_sha256 == second
    assert [label.sha256 for label in history(url, "SN1").history.labels][:2] == [first, second]
    assert sign(url, second, "approved", "C. Lim", NOW).is_approved
    assert verify_archive(url).faults == ()


@pytest.mark.parametrize(("name", "reason"), [("B.\u202eSoo", "small"), ("B. Soo", "small\n2026-06-01 approved")])
def test_a_word_that_a_page_cannot_show_as_it_is_is_refused(archive: Any, name: str, reason: str) -> None:
    publish(archive.url, [set_with_findings(approved_by=None)], NOW)
    sign(archive.url, "SN1047", "prepared", "A. Ray", NOW)
    with pytest.raises(ArchiveForbids, match=r"holds U\+(202E|000A), which nobody sees: .*; nothing was signed"):
        accept(archive.url, "SN1047", "y.cubic", name, NOW, reason)
    with pytest.raises(ArchiveForbids, match="which nobody sees"):
        sign(archive.url, "SN1047", "reviewed", name, NOW, reason)


def test_a_withdrawn_set_does_not_leave_the_archive_and_is_nobodys_previous(archive: Any) -> None:
    url = archive.url
    publish_run(url, a_run(0), [a_sensor(0)], NOW)
    for role, name in (("prepared", "A. Ray"), ("reviewed", "B. Chief"), ("approved", "C. Lim")):
        sign(url, "SN1", role, name, NOW)
    sha256 = list_sets(url, "SN1")[0].sha256
    assert set_to_use(url, "SN1").sha256 == sha256
    sign(url, "SN1", "withdrawn", "C. Lim", NOW, "the meter was wrong.")
    said = f"set {sha256[:12]} of SN1 is withdrawn by C. Lim on {NOW:%Y-%m-%d} (UTC): the meter was wrong; it is not"
    for key in ("SN1", sha256[:12], sha256):
        with pytest.raises(ArchiveForbids, match=re.escape(said) + ".*nothing was written; calibrate again"):
            set_to_use(url, key)
    publish_run(url, a_run(30), [a_sensor(30)], NOW)
    after = adjustment_of(url, "SN1")
    assert after is not None
    assert after.as_found is None
    newest = list_sets(url, "SN1")[-1].sha256
    assert set_to_use(url, "SN1").sha256 == newest
    with pytest.raises(
        ArchiveForbids, match=rf"by its checksum \({newest[:12]} of 20\d\d-\d\d-\d\d\), or calibrate again"
    ):
        set_to_use(url, sha256)
