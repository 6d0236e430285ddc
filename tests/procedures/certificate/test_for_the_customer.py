"""What a certificate says of a finding: what the data show of the item, and nothing of what the laboratory can do."""

import json
from dataclasses import replace
from datetime import date
from html import unescape

import numpy as np
import pytest
from certificate_scene import RELEASED, set_with_findings
from physics_scenes import campaigns
from solved import provenance
from solved_campaigns import columns_of, rows_of

from ams.archive.sign_offs import SignOff
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.exports.dcc import to_dcc
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.sets.coefficients import build_set
from ams.sets.stated_findings import fact_of, findings_of_set, significant_findings
from procedures.certificate.grounds import Grounds
from procedures.certificate.page import certificate_page

OF_THE_LABORATORY = ("calrig ", "NAME", " --", "[solve]", "solve again", "measure again", "measure it again")
"""Commands, keys of files and ways out: none of it is for whom the item belongs to."""
SCENES = (
    ("wrong-dwell", 100.0),
    ("slip-roll", 72.0),
    ("slip-pitch", 72.0),
    ("drift-settling", 20.0),
    ("drift-raster", 20.0),
    ("after-effect", 20.0),
    ("temperature-in-step", 1.0),
    ("noisy-replication", 9.0),
)


def _calibrated(scene: str, size: float) -> Calibration:
    """Return the result of a run whose steps and name are known, so that findings have whole commands."""
    drawn = campaigns(scene, size, np.random.default_rng(5), 1)
    outputs = {axis: columns_of(drawn, axis)[:, 0] for axis in drawn.setup.axes}
    rows = rows_of(drawn)
    rows = replace(rows, outputs=outputs, step=np.arange(1, rows.rows + 1), run="runs/a")
    return calibrate(rows, CalibrationRequest(nominal_axes={axis: axis for axis in outputs}))


def _significant(calibration: Calibration) -> list[Finding]:
    return [finding for axis in calibration.axes.values() for finding in axis.findings if finding.is_significant]


@pytest.mark.parametrize(("scene", "size"), [("wrong-dwell", 100.0), ("slip-roll", 72.0), ("slip-pitch", 72.0)])
def test_findings_of_a_run_stand_on_certificate_and_dcc_without_commands(scene: str, size: float) -> None:
    calibration = _calibrated(scene, size)
    with_commands = [finding for finding in _significant(calibration) if "calrig " in finding.what_to_do]
    assert with_commands
    entry = build_set(calibration, provenance(**RELEASED))
    grounds = Grounds("2026-0117", date(2026, 3, 3), entry, None, SignOff(entry.sha256, (), ()))
    page, dcc = unescape(certificate_page(grounds)), to_dcc(entry).decode("utf-8")
    reservations = page[page.index("Verdict of the calibration") : page.index("Authorisation")]
    for finding in with_commands:
        assert finding.fact[1:60] in reservations
        assert finding.fact[1:60] in dcc
        assert finding.what_to_do not in reservations
    for word in OF_THE_LABORATORY:
        assert word not in reservations
    assert "calrig void" not in dcc
    assert "calrig redo" not in dcc


@pytest.mark.parametrize(("scene", "size"), SCENES)
def test_a_fact_holds_no_way_out_and_the_text_holds_both(scene: str, size: float) -> None:
    found = _significant(_calibrated(scene, size))
    assert any(finding.what_to_do for finding in found)
    for finding in found:
        assert not [word for word in OF_THE_LABORATORY if word in finding.fact], finding.fact
        stated = finding.to_document()
        parts = [finding.fact, finding.what_to_do] if finding.what_to_do else [finding.fact]
        assert finding.text == stated["text"] == "; ".join(parts)
        assert json.loads(json.dumps(stated)).get("what_to_do", "") == finding.what_to_do


def test_a_set_gives_back_fact_and_way_out_and_one_of_before_its_whole_text() -> None:
    finding = Finding("cubic", "it bends", is_significant=True, what_to_do="take another (calrig redo)")
    entry = set_with_findings()
    document = json.loads(json.dumps(entry.document))
    document["axes"]["y"]["findings"] = [finding.to_document()]
    known = replace(entry, document=document)
    assert next(findings_of_set(known)) == finding
    assert fact_of(document, finding.text) == "it bends"
    assert fact_of(document, "said of no finding; calrig redo") == "said of no finding; calrig redo"
    before = {"kind": "cubic", "text": finding.text, "significant": True, "p_value": None}
    document["axes"]["y"]["findings"] = [before]
    (stated,) = significant_findings(known)
    assert stated.fact == stated.text == finding.text == next(findings_of_set(known)).text
