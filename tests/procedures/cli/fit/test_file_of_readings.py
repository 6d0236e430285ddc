"""A set that was solved from a file says which, and its certificate claims no motion of a rig."""

import hashlib
from datetime import date
from html import unescape
from pathlib import Path

import pytest
from command import call
from package_outputs import write_observations
from solved import provenance, solved_package

from ams.archive.sign_offs import SignOff
from ams.exports.formats import load_set
from ams.sets.coefficients import CoefficientSet, build_set
from procedures.certificate.grounds import NO_READINGS, Grounds, gaps_of
from procedures.certificate.page import certificate_page

AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
MOVED = "turned to known attitudes by the axes of the rig"
LIMITS = {"pitch_limit_deg": 0.003}


def _grounds(coefficients: CoefficientSet) -> Grounds:
    signed = SignOff(coefficients.sha256, (), ())
    return Grounds("2026-1", date(2026, 3, 3), coefficients, None, signed, is_specimen=True)


def _page(coefficients: CoefficientSet) -> str:
    return " ".join(unescape(certificate_page(_grounds(coefficients))).split())


@pytest.mark.parametrize(
    ("options", "said"),
    [((), None), (("--calibrated-on", "2026-02-12"), "whoever solved it")],
)
def test_name_checksum_and_rows_of_the_file_stand_in_the_set_and_on_its_certificate(
    options: tuple[str, ...], said: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_observations(tmp_path / "obs.csv", range(-60, 61, 30), range(-180, 180, 60), 2, noise_v=6e-6)
    where = ("--set", tmp_path / "s.json", "--sensor", "SN1", "--gravity-mps2", "9.8")
    assert call(capsys, "fit", file, *AXES, *where, *options).status == 0
    found = load_set(tmp_path / "s.json")
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    stated = {"file": "obs.csv", "sha256": sha256, "rows": 60} | ({"day_stated_by": said} if said else {})
    assert found.provenance["readings"] == stated
    page = _page(found)
    assert f'handed over in the file “obs.csv” (SHA-256 <span class="code">{sha256}</span>), of which 60 rows' in page
    assert ("The day on which they were taken is as whoever solved it states it." in page) == (said is not None)
    assert MOVED not in page
    assert "Run not recorded" not in page
    assert NO_READINGS not in list(gaps_of(_grounds(found)))


def test_a_set_of_a_run_claims_its_motion_and_one_of_nothing_known_has_a_gap() -> None:
    of_run, of_nothing = (build_set(solved_package(), provenance(**known)) for known in ({}, {"run_id": None}))
    assert MOVED in _page(of_run)
    assert NO_READINGS not in list(gaps_of(_grounds(of_run)))
    assert NO_READINGS in "".join(gaps_of(_grounds(of_nothing)))
    assert NO_READINGS in _page(of_nothing)
    assert MOVED not in _page(of_nothing)


def test_limits_that_nothing_judges_by_are_not_said_to_be_none() -> None:
    declared, bare = (build_set(solved_package(), provenance(acceptance=given)) for given in (LIMITS, None))
    assert "Not judged: limits are declared, and the archive holds no readings of this set" in _page(declared)
    assert "Not judged" not in _page(bare)
