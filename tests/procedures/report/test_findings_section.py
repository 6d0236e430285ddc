"""The section of findings: what was tested, on which channel, and what of it somebody must read."""

import re
from dataclasses import replace
from datetime import UTC, datetime

import pytest
from report_scene import Scene, run_view

from ams.archive.sign_offs import AcceptedFinding, Release, SignOff
from ams.findings import Finding
from ams.sets.signature import Signature
from ams.sets.stated_findings import StatedFinding
from procedures.report.figures import Figures
from procedures.report.findings_in_short import test_name as name_of
from procedures.report.page import render_page
from procedures.report.view import AxisFindings


def _page(scene: Scene) -> str:
    view = run_view(scene)
    return render_page(view, Figures((), {sensor.name: () for sensor in view.sensors}))


def test_every_test_of_every_axis_stands_in_the_table_and_in_the_contents() -> None:
    page = _page(Scene())
    assert '<a href="#findings">Findings</a>' in page
    section = page[page.index('<h2 id="findings">') : page.index('<h2 id="run">')]
    assert section.count("wrong dwell</td>") == section.count("lack of fit</td>") == 3
    assert "<td>yes</td>" not in section


def test_a_significant_finding_is_marked_and_its_sentence_stands_beside_it() -> None:
    page = _page(Scene(offset_drift_v=4e-6))
    section = page[page.index('<h2 id="findings">') : page.index('<h2 id="run">')]
    assert section.count('<td class="s sig">drift of offset</td>') == 3
    assert section.count("offset changed by 12″") == 3
    assert "SN1047 x, y, z: offset changed by 12″" in page[: page.index('<h2 id="findings">')]


def test_without_tests_there_is_no_section() -> None:
    assert 'id="findings"' not in _page(Scene(replications=1))


def test_who_accepted_a_finding_and_who_signed_stand_on_the_page() -> None:
    """As in the archive when the page is made: `calrig solve` makes it again."""
    view, when = run_view(Scene(offset_drift_v=4e-6)), datetime(2026, 3, 2, 9, tzinfo=UTC)
    finding = StatedFinding("x.drift", "x", "offset changed by 12″.", "offset changed by 12″.")
    signed = SignOff(
        "0" * 64, (Signature("prepared", "A. Operator", when, ""), Signature("approved", "B. Chief", when, "")), (),
        (finding, StatedFinding("y.drift", "y", "said of y.", "said of y.")),
        (AcceptedFinding("x.drift", "B. Chief", when, "known"),),
        "the table turned", Release("C. Head", when, "checked by hand"),
    )  # fmt: skip
    sensors = (replace(view.sensors[0], signed=signed), *view.sensors[1:])
    page = render_page(replace(view, sensors=sensors), Figures((), {sensor.name: () for sensor in sensors}))
    words = " ".join(re.sub(r"<[^>]+>", " ", page).split())
    assert "axis x: offset changed by 12″. Accepted by B. Chief, 2026-03-02 09:00:00 UTC: known" in words
    assert "said of y." not in words, "nobody accepted it"
    assert "the table turned. Released by C. Head, 2026-03-02 09:00:00 UTC: checked by hand" in words
    assert "prepared by A. Operator, 2026-03-02 09:00:00 UTC; approved by B. Chief" in words


def test_of_several_sensors_what_rings_stands_in_rows_and_every_test_in_one() -> None:
    page = _page(Scene(sensors=("SN1", "SN2"), offset_drift_v=4e-6))
    section = page[page.index('<h2 id="findings">') : page.index('<h2 id="run">')]
    assert section.count("offset changed by 12″") == 1
    assert ">all 2 sensors, x, y, z</td>" in section
    assert section.count(">lack of fit</td>") == 1
    row = section[section.index(">drift of offset</td>", section.rindex("Smallest p")) :]
    assert row[: row.index("</tr>")].count('<td class="n">6</td>') == 2  # channels tested, and significant on
    quiet = _page(Scene(sensors=("SN1", "SN2")))
    assert "None is significant." in quiet[quiet.index('<h2 id="findings">') : quiet.index('<h2 id="run">')]


def test_a_set_that_is_approved_though_not_usable_says_so_on_the_page_in_the_words_of_the_archive() -> None:
    view, when = run_view(Scene(offset_drift_v=4e-6)), datetime(2026, 3, 2, 9, tzinfo=UTC)
    signed = SignOff(
        "0" * 64, (Signature("approved", "B. Chief", when, ""),), (),
        verdict="not usable", accepted_verdict=AcceptedFinding("not usable", "C. Head", when, "a rehearsal"),
    )  # fmt: skip
    sensors = (replace(view.sensors[0], signed=signed), *view.sensors[1:])
    page = render_page(replace(view, sensors=sensors), Figures((), {sensor.name: () for sensor in sensors}))
    words = " ".join(re.sub(r"<[^>]+>", " ", page).split())
    assert "The set is approved though not usable, accepted by C. Head: a rehearsal" in words
    assert "the calibration is not usable. Accepted by C. Head, 2026-03-02 09:00:00 UTC: a rehearsal" in words


def test_on_a_narrow_screen_the_sentences_of_findings_stand_below_their_tests() -> None:
    """A table as wide as its sentences leaves a phone with the names of the tests alone."""
    for sensors in (("SN1",), ("SN1", "SN2")):
        page = _page(Scene(sensors=sensors, offset_drift_v=4e-6))
        assert '<table class="told">' in page[page.index('<h2 id="findings">') :]
        assert ".told td.w:last-child { flex: 1 0 100%" in page


@pytest.mark.parametrize(
    ("unit", "measured_unit", "size", "uncertainty", "words"),
    [
        ("V/g²", "V", -2e-6, 5e-7, "−2.0 ± 1.0 µV/g²"),
        ("rad", "V", 1e-5, 1e-6, "2.1 ± 0.41″"),  # an angle in radians is 206 265″
        ("per °C", "V", 3e-5, 1e-5, "30 ± 20 µV per °C"),
        ("", "V", 3e-6, 1e-6, "3.0 ± 2.0 µV"),
        ("", "counts", -3.0, 1.0, "−3.0 ± 2.0 counts"),
        ("ppm", "V", 4.0, 1.0, "4.0 ± 2.0 ppm"),
    ],
)
def test_the_size_of_a_term_has_the_unit_that_it_was_found_in(unit, measured_unit, size, uncertainty, words) -> None:
    details = {"size": size, "standard_uncertainty": uncertainty, "unit": unit}
    finding = Finding("lack-of-fit", "", False, 0.5, details=details)
    assert AxisFindings("x", "dmm.x", (finding,), measured_unit).size_of(finding) == words


def test_terms_have_their_symbols_in_the_tables_and_other_tests_their_names() -> None:
    names = {"K0'": "K₀′", "Kip": "K_ip", "squareness of the table's axes": "squareness of the table's axes"}
    for test, shown in names.items():
        assert name_of(Finding("asymmetry", "", False, 0.5, details={"test": test})) == shown
    assert name_of(Finding("lack-of-fit", "", False, 0.5)) == "lack of fit"
