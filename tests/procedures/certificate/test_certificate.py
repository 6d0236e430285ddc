"""The certificate against the clauses of ISO/IEC 17025:2017, 7.8, and against arithmetic done here."""

import re
from dataclasses import replace
from datetime import UTC, date, datetime
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from certificate_scene import JOB, LABORATORY, LEVEL, LEVEL_STANDARD, METER, RELEASED, STANDARD, set_with_findings
from line_sets import line_set
from not_usable import set_not_usable
from planning_files import rig_file
from solved import PARAMETERS, provenance, solved_package
from solved_sets import gyro_set

from ams.archive.sign_offs import AcceptedFinding, Release, SignOff
from ams.calibration_result import VarianceComponent
from ams.exports.dcc import to_dcc
from ams.findings import Finding
from ams.inputs.shared_errors import G_SENSITIVITY, NONLINEARITY, SHIFTS, SHIFTS_WITHIN
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty
from ams.observations import Observations
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Standard
from ams.sets.signature import Signature
from ams.sets.stated_findings import LACKING, StatedFinding, significant_findings
from ams.sets.verdict_conditions import CURVATURE_UNDETERMINED, REFERENCE_NOT_MEASURED
from ams.solve.table_errors import TablePriors
from ams.surveillance.adjustment import Acceptance, Adjustment, adjust
from ams.surveillance.reference_attitude import ReferenceAttitude, ReferenceInWords
from procedures.certificate.grounds import Amendment, Grounds, check_grounds, gaps_of
from procedures.certificate.page import SPECIMEN, certificate_page, certificate_paper
from procedures.certificate.results import coefficients_of
from procedures.cli.archive.text import sign_off_lines
from procedures.errors import RequestError
from procedures.plan.undeclared import Undeclared
from procedures.records.declared_gaps import level_remarks, meter_remarks, thermometer_remarks
from procedures.report.paper.page_tree import page_tree_of

SIGNED = datetime(2026, 3, 2, 9, tzinfo=UTC)


def _set(**changes: object) -> CoefficientSet:
    return build_set(solved_package(), provenance(**{**RELEASED, **changes}))


def _measured(coefficients: CoefficientSet, off_deg: float = 0.0) -> Observations:
    """Two replications of a grid whose outputs are those of the set, at a pitch that is off by a constant."""
    grid = [(p, r) for p in range(-60, 61, 30) for r in range(-180, 180, 60)] * 2
    pitch, roll = np.deg2rad(np.array(grid, dtype=float)).T
    outputs = apply(coefficients, pitch + np.deg2rad(off_deg), roll)
    count = len(grid) // 2
    return Observations(np.repeat([1, 2], count), np.tile(np.arange(1, count + 1), 2), pitch, roll, outputs)


def _adjustment(coefficients: CoefficientSet, off_deg: float = 0.0, limit_deg: float = 0.01) -> Adjustment:
    return adjust(None, coefficients, _measured(coefficients, off_deg), Acceptance({"pitch": limit_deg}), (-45.0, 45.0))


def _grounds(**changes: object) -> Grounds:
    entry = _set()
    signed = (Signature("prepared", "A. Operator", SIGNED, ""), Signature("approved", "B. Chief", SIGNED, ""))
    grounds = Grounds("2026-0117", date(2026, 3, 3), entry, _adjustment(entry), SignOff(entry.sha256, signed, ()))
    return replace(grounds, **changes)  # type: ignore[arg-type]


def _text(grounds: Grounds) -> str:
    page = re.sub(r"<style>.*?</style>", "", certificate_page(grounds), flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", page)).split())


def test_whose_axes_the_coefficients_are_in_is_said_of_a_package_that_sat_turned() -> None:
    turned = _grounds(coefficients=_set(mount={"x": "+x", "y": "-y", "z": "-z"}))
    assert "on which the package sat with its own x, y, z along +x, −y, −z of the fixture." in _text(turned)
    assert "of the fixture" not in _text(_grounds(coefficients=_set(mount={"x": "+x", "y": "+y", "z": "+z"})))


def test_straight_lines_are_certified_in_the_unit_of_what_they_sense() -> None:
    """As found by hand: the line before told 0.3 µT too much everywhere."""
    entry, before = line_set({"x": (0.032, -0.4)}), line_set({"x": (0.032, -0.1)})
    nothing = Observations(np.ones(0), np.ones(0), np.zeros(0), np.zeros(0), {})
    text = _text(_grounds(coefficients=entry, adjustment=adjust(before, entry, nothing, Acceptance({}))))
    for said in ("gain A µT/counts 0.032", "exposed to known levels of what it senses", "Level x -40.000 to 40.000 µT"):
        assert said in text.replace("−", "-"), said
    assert re.search(r"any adjustment \(set of .*\), at most: x 0\.30*\d* µT", text)


def test_it_says_what_of_the_reference_attitude_its_uncertainty_counts() -> None:
    """A table of u 3.6″ is 0.0010° in every error: more than anything else here, and in every U that is printed."""
    entry, u_rad = _set(), np.deg2rad(0.001)
    shapes = dict.fromkeys(("pitch", "roll"), IndexErrors("independent"))
    errors = TablePriors(TableUncertainty(u_rad, u_rad, errors=shapes))
    reference = ReferenceAttitude(errors, ReferenceInWords("table: pitch u 3.6″", "the level of the base"))
    limit, rows = Acceptance({"pitch": 0.01}), _measured(entry)
    found = adjust(None, entry, rows, limit, (-45.0, 45.0), None, reference)
    text = _text(_grounds(adjustment=found))
    assert "U counts what the reference attitude itself is wrong by (table: pitch u 3.6″)." in text
    assert "Not in U, an error of the reference all the same: the level of the base." in text
    assert "reference attitude 0.0010°" in text
    assert f"U {found.as_left.judgements[0].expanded_deg:.4f}°" in text
    assert found.as_left.judgements[0].expanded_deg > 1.9 * 0.001


def test_it_holds_what_clause_7_8_asks_for() -> None:
    text = _text(_grounds())
    request = {
        "7.8.2.1 a title": "Calibration certificate",
        "b laboratory": "Instrument Laboratory",
        "c place": "Place 1 Granite Way, Hampton",
        "d identification": "2026-0117",
        "d end": "End of certificate 2026-0117",
        "e customer": "Customer Tunnel Ltd",
        "e contact of the customer": "Customer’s contact 2 Wind Road, tunnel@example.com",
        "f method": "NASA/TP-1999-209835",
        "g item": "inclinometer package, clean, no damage",
        "g unambiguous": "1047",
        "i date of the activity": "2026-02-28 to 2026-03-01",
        "j date of issue": "2026-03-03",
        "l only these items": "relate only to the items calibrated",
        "m units": "V/g",
        "o authorised by": "B. Chief",
        "7.8.2.1 reproduction": "shall not be reproduced except in full",
        "7.8.4.1 a uncertainty": "coverage probability of 95 %",
        "7.8.4.1 b conditions": "19.60 to 20.40 °C",
        "7.8.4.1 c traceability": "C-2025-14",
        "7.8.4.1 d before adjustment": "As found",
        "7.8.6.2 decision rule": "ILAC-G8:09/2019",
    }
    assert {clause: words for clause, words in request.items() if words not in text} == {}
    assert not re.search(r"next calibration|recalibrat|interval advice", text, re.IGNORECASE)  # 7.8.4.3


def test_no_uncertainty_is_below_the_capability() -> None:
    # 0.002 deg = 3.4907e-5 rad; the calculated expanded uncertainties here are about 2.6e-6
    rows = {(row.axis, row.label): row for row in coefficients_of(_set(), 0.002)}
    for axis, (_, sensitivity, coning_deg, _) in PARAMETERS.items():
        effect = abs(sensitivity) * 3.4906585e-5
        expected = {
            "offset": effect, "sensitivity": effect, "coning angle": 0.002,
            "azimuth": 0.002 / np.sin(np.radians(coning_deg)),
        }  # fmt: skip
        for label, floor in expected.items():
            row = rows[axis, label]
            assert row.is_capability
            assert float(row.expanded) == pytest.approx(floor, rel=0.05)  # two digits are printed


def test_it_says_whether_its_uncertainties_count_what_comes_after_the_calibration() -> None:
    """EA-4/02 leaves the drift of an item out of what a laboratory states: what is in it must be said."""
    assert "what the item may shift by afterwards is not in it" in _text(_grounds())
    solved = solved_package()
    shifts = [
        VarianceComponent(name, np.diag([1e-12, 0.0, 0.0, 0.0]), np.inf)
        for name in (SHIFTS[0], SHIFTS_WITHIN[0], NONLINEARITY, G_SENSITIVITY)
    ]
    both = "during the calibration and until the next"
    for count, words in ((1, "until the next"), (2, both), (3, both), (4, both)):
        axes = {
            name: replace(axis, variance_components=(*axis.variance_components, *shifts[:count]))
            for name, axis in solved.axes.items()
        }
        entry = build_set(replace(solved, axes=axes), provenance(**RELEASED))
        text = _text(_grounds(coefficients=entry, is_specimen=True))
        assert f"U counts what offset may shift by {words} calibration" in text
        assert ("It counts how far a reading may be from the equation" in text) == (count >= 3)
        assert ("what gravity does to the zero of a gyro at any attitude of use" in text) == (count == 4)


def test_a_gyro_has_a_certificate_on_which_an_angle_by_gravity_sets_no_bound() -> None:
    """A set of gyros states no sensitivity per g."""
    entry = gyro_set()
    rows = list(coefficients_of(entry, 0.002))
    assert {row.axis for row in rows} == {"x", "y", "z"}
    assert [row.expanded for row in rows] == [row.expanded for row in coefficients_of(entry, None)]
    assert not any(row.is_capability for row in rows)
    specimen = _grounds(coefficients=entry, adjustment=None, is_specimen=True)
    assert "V/(°/s)" in _text(specimen)
    page_tree_of(certificate_page(specimen))


def test_a_calculated_uncertainty_above_the_capability_is_stated_with_its_k() -> None:
    row = next(iter(coefficients_of(_set(), 1e-9)))
    assert not row.is_capability
    assert float(row.factor) == pytest.approx(2.54, abs=0.01)  # Student's t, 95 %, 5.2 degrees of freedom
    assert float(row.expanded) == pytest.approx(2.54e-6, rel=0.05)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"simulated": True}, "the readings come from a twin"),
        ({"laboratory": None}, "[laboratory] name"),
        ({"laboratory": {**LABORATORY, "capability_deg": None}}, "[laboratory] capability_deg"),
        ({"job": {"item": "x"}}, "[job] customer"),
        ({"job": {**JOB, "customer_contact": None}}, "[job] customer_contact"),
        ({"standards": ()}, "no standard is declared"),
        ({"standards": (STANDARD,)}, "no uncertainty of the meter is declared: none of the standards states"),
        ({"standards": (replace(STANDARD, due=date(2026, 2, 1)),)}, "standard table was due on 2026-02-01"),
    ],
)
def test_a_gap_is_refused_by_name(changes: dict[str, object], words: str) -> None:
    with pytest.raises(RequestError, match=re.escape(words)):
        check_grounds(_grounds(coefficients=_set(**changes)))


def test_without_an_approval_there_is_no_certificate() -> None:
    with pytest.raises(RequestError, match="nobody has signed the set as approved"):
        check_grounds(_grounds(signed=SignOff("", (Signature("prepared", "A. Operator", SIGNED, ""),), ())))


def test_the_day_of_receipt_stands_where_it_is_on_record_and_the_files_by_the_record_that_holds_them() -> None:
    """7.8.2.1 asks for the day only where it is critical: nothing is said of one that nobody wrote down."""
    assert "Received" not in _text(_grounds())
    assert "Received 2026-02-20" in _text(_grounds(coefficients=_set(job={**JOB, "received": "2026-02-20"})))
    files = "whose record holds the rig and the procedure file as they were (SHA-256 0123abcd )"
    assert files in _text(_grounds(coefficients=_set(run_id="r-1", journal_sha256="0123abcd")))
    assert "whose record" not in _text(_grounds(coefficients=_set(journal_sha256=None)))


def test_volts_without_a_standard_are_not_called_traceable() -> None:
    """The table's certificate tells of angles: VIM 2.41 wants an unbroken chain for the quantity that is stated."""
    whole = "The results are traceable to the International System of Units through the certificates named."
    assert whole in _text(_grounds())
    of_table = _text(_grounds(coefficients=_set(standards=(STANDARD,)), is_specimen=True))
    assert whole not in of_table
    assert (
        "The voltages are not, nor is any result stated in volts: no uncertainty of the meter is declared" in of_table
    )


def test_a_meter_that_the_set_names_is_a_gap_whatever_another_standard_states() -> None:
    plain = solved_package()
    said = Finding("meter-undeclared", "no uncertainty of the meter is declared (second).", False)
    axes = {**plain.axes, "y": replace(plain.axes["y"], findings=(said,))}
    entry = build_set(replace(plain, axes=axes), provenance(**{**RELEASED, "standards": (STANDARD, METER)}))
    with pytest.raises(RequestError, match=re.escape("no uncertainty of the meter is declared (second).")):
        check_grounds(_grounds(coefficients=entry))


def test_a_crosstalk_that_nobody_declared_is_a_gap_and_the_meter_is_traceable_all_the_same() -> None:
    plain = solved_package()
    said = Finding("meter-undeclared", "no crosstalk of the scanner is declared (dmm): it leaks.", False)
    axes = {**plain.axes, "y": replace(plain.axes["y"], findings=(said,))}
    entry = build_set(replace(plain, axes=axes), provenance(**{**RELEASED, "standards": (STANDARD, METER)}))
    assert said.text in list(gaps_of(_grounds(coefficients=entry)))
    assert "The voltages are not" not in _text(_grounds(coefficients=entry, is_specimen=True))


def _dwell(replication: int, point: int, *reasons: str, again: bool = True) -> dict[str, object]:
    return {
        "purpose": "design",
        "replication": replication,
        "point": point,
        "attempt": 1,
        "reasons": list(reasons),
        "measured_again": again,
    }


@pytest.mark.parametrize(
    ("rejected", "sentence"),
    [
        ([], "All 40 dwells that were measured count; none was rejected or taken back."),
        (
            [_dwell(2, 7, "a")],
            "measured 1 was rejected or taken back and does not count; it was measured again.",
        ),
        ([_dwell(1, 3, "a"), _dwell(2, 7, "b", again=False)], "2 were rejected or taken back and do not count; 1 of"),
        ([_dwell(1, 3, "a", again=False)], "does not count; it was not measured again."),
    ],
)
def test_how_many_dwells_do_not_count_stands_on_page_paper_and_dcc(
    rejected: list[dict[str, object]], sentence: str
) -> None:
    grounds = _grounds(coefficients=_set(dwells={"measured": 40, "rejected": rejected}))
    for text in (_text(grounds), _words_of_dcc(grounds)):
        assert sentence in text
        for dwell in rejected:
            assert f"design, replication {dwell['replication']}, point {dwell['point']}, attempt 1" in text
    visits = {"measured": 278, "reference_visits": 26, "rejected": rejected}
    among = "252 of the design and 26 at reference attitudes"
    assert among in _text(_grounds(coefficients=_set(dwells=visits)))
    assert "does not state how many dwells" in _text(_grounds()), "a set of before the key"


def test_many_dwells_that_were_taken_back_for_one_reason_are_one_line_and_none_is_lost_from_the_set() -> None:
    together = [_dwell(3, point, "taken back by B. Chief: the door stood open") for point in range(1, 13)]
    apart = [_dwell(1, point, f"dmm.x: noise: {point}") for point in range(1, 31)]
    entry = _set(dwells={"measured": 100, "rejected": [*together, *apart]})
    text = _text(_grounds(coefficients=entry))
    assert "12 dwells, replication 3, points 1 to 12 taken back by B. Chief: the door stood open" in text
    assert "11 more each with its reasons in the coefficient set" in text
    assert len(entry.provenance["dwells"]["rejected"]) == 42  # type: ignore[call-overload, index]


def test_every_equipment_stands_with_what_it_was_used_for_and_a_thermometer_without_a_standard_is_named() -> None:
    table = replace(STANDARD, used_for=("axes.pitch", "axes.roll"))
    probe = Standard("probe", "T-9", "C-2025-30", date(2027, 2, 1), {"uncertainty_degc": 0.1}, ("environment.air",))
    meter = replace(METER, used_for=("readouts.dmm",))
    of_level = ("level of the base (Talyvel 6)", "L-12", "C-2025-9", "2027-01-31")
    of_probe = ("temperature (air)", "T-9", "C-2025-30", "2027-02-01")
    with_probe = _grounds(coefficients=_set(standards=(table, meter, probe, LEVEL_STANDARD)))
    for text in (_text(with_probe), _words_of_dcc(with_probe)):
        for said in ("attitude (pitch, roll)", "outputs (dmm)", *of_probe, *of_level):
            assert said in text, said
        assert "local gravity" in text
    assert "not shown to be traceable" not in _text(with_probe)
    without = _grounds(coefficients=_set(standards=(table, meter, LEVEL_STANDARD)))
    assert "Of air (temperature) no uncertainty is declared" in _text(without)
    assert "no certificate of its uncertainty is declared" in _words_of_dcc(without)
    assert "The results are traceable" not in _text(without)


def test_a_meter_and_its_scanner_stand_among_the_equipment_with_and_without_a_certificate() -> None:
    """Of a run: what read the outputs, and what it told of itself. A scanner determines nothing that is traceable."""
    dmm = {"driver": "hp3458a", "identity": "HP3458A, HP3488A", "axes": ["x", "y"], "scanned": True}
    plain = {"standards": (replace(STANDARD, used_for=("axes.pitch",)), LEVEL_STANDARD), "environment": {}}
    without = _grounds(coefficients=_set(**plain, readouts={"dmm": dmm}))
    for text in (_text(without), _words_of_dcc(without)):
        assert "scanner of dmm" in text
        assert "outputs (x, y); crosstalk not declared" in text
    assert "dmm outputs (x, y) — none declared" in _text(without)
    assert "Dmm, as it told: HP3458A, HP3488A." in _text(without)
    assert "Of dmm (outputs (x, y)) no uncertainty is declared" in _text(without)
    standards = {**plain, "standards": (*plain["standards"], replace(METER, used_for=("readouts.dmm",)))}
    leaking = {"dmm": {**dmm, "crosstalk_ratio": 1e-5}}
    declared = _text(_grounds(coefficients=_set(**standards, readouts=leaking)))
    assert "scanner of dmm outputs (x, y); crosstalk 1e-05, declared — none declared" in declared
    assert "The results are traceable to the International System of Units" in declared
    assert "Of dmm" not in declared


def test_humidity_and_supply_stand_under_the_conditions_or_are_said_not_to_be_recorded() -> None:
    read = {"dmm.s": {"mean_v": 5.0001, "min_v": 4.9998, "max_v": 5.0004}}
    recorded = _grounds(coefficients=_set(job={**JOB, "relative_humidity_percent": [38.0, 46.5]}, supplies=read))
    for said in ("Relative humidity 38 to 46.5 %", "Supply of the item, dmm.s 4.9998 to 5.0004 V"):
        assert said in _text(recorded)
    for said in ("lowest relative humidity", "46.5", r"\percent", "supply dmm.s", "4.9998"):
        assert said in _words_of_dcc(recorded)
    lacking = _text(_grounds(coefficients=_set(supplies={})))
    assert "Relative humidity not recorded" in lacking
    assert "Supply of the item not recorded" in lacking
    assert "Supply of the item not stated" in _text(_grounds()), "a set of before the key"


def test_what_is_in_the_uncertainty_without_a_certificate_is_not_called_traceable() -> None:
    """Gravity that is only said to be known, a level with a name, a limit or a reading only: somebody's word."""
    table = replace(STANDARD, used_for=("axes.pitch", "axes.roll"))
    standards = (table, replace(METER, used_for=("readouts.dmm",)))
    probe = Standard("probe", "T-9", "C-2025-30", date(2027, 2, 1), {"uncertainty_degc": 0.1}, ("environment.air",))
    of_level = {"standards": (*standards, probe)}
    whole = "The results are traceable to the International System of Units through the certificates named."
    every: dict[str, object] = {"standards": (*standards, probe, LEVEL_STANDARD)}
    assert whole in _text(_grounds(coefficients=_set(**every)))
    for changed, named in (
        ({"gravity_source": ""}, "Of local gravity (unit of acceleration) no certificate is named"),
        (of_level, "Of Talyvel 6 (level of the base) no certificate is named"),
        (of_level | {"level": {"uncertainty_arcsec": 0.5}}, "Of level (level of the base) no certificate is named"),
        (of_level | {"level": {"before": LEVEL["before"]}}, "Of level (level of the base) no certificate is named"),
    ):
        grounds = _grounds(coefficients=_set(**{**every, **changed}))
        text = _text(grounds)
        assert f"{named}: what rests on it is not shown to be traceable." in text
        assert whole not in text
        assert "no certificate of its uncertainty is declared" in _words_of_dcc(grounds)


def _words_of_dcc(grounds: Grounds) -> str:
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", to_dcc(grounds.coefficients).decode("utf-8"))).split())


def test_the_verdict_of_a_set_stands_with_what_it_is_without() -> None:
    remarks = ("the level of the base is not declared: a tilted base", "no uncertainty of the meter is declared: 0")
    plain = replace(solved_package(), remarks=remarks)
    grounds = _grounds(coefficients=build_set(plain, provenance(**RELEASED)))
    ending = "sound , without the level of the base and the uncertainty of the meter, which are not declared."
    assert f"Verdict of the calibration: {ending}" in _text(grounds)
    assert f"verdict of the calibration {ending[:-1].replace(' ,', ',')}" in _words_of_dcc(grounds)


def test_a_gravity_without_an_uncertainty_is_a_gap_where_sensitivities_are_per_local_g() -> None:
    """Of a set of before the finding as well: nothing in it says how far its gravity may be wrong."""
    alone = _grounds(coefficients=_set(gravity_uncertainty_mps2=0.0))
    (gap,) = [text for text in gaps_of(alone) if "local gravity" in text]
    assert gap.startswith("no uncertainty of local gravity is declared (9.79826 m/s²)")
    assert "rig.gravity_uncertainty_mps2" in gap
    assert "9.79826 m/s², no uncertainty declared (survey 2024)" in _text(alone)
    assert "9.79826 m/s², standard uncertainty 2 µm/s² (survey 2024)" in _text(_grounds())
    assert not [text for text in gaps_of(_grounds(coefficients=gyro_set())) if "local gravity" in text]


def test_counts_need_no_standard_of_volts() -> None:
    entry = line_set({"x": (0.032, -0.4)})
    assert not any("the meter" in gap for gap in gaps_of(_grounds(coefficients=entry, adjustment=None)))


def test_a_complete_ground_is_not_refused() -> None:
    check_grounds(_grounds())
    assert SPECIMEN not in _text(_grounds())


def test_work_done_elsewhere_has_its_place_and_the_laboratory_its_address() -> None:
    text = _text(_grounds(coefficients=_set(job={**JOB, "location": "hall 3 of Tunnel Ltd"})))
    assert "Place hall 3 of Tunnel Ltd" in text
    assert "Instrument Laboratory · 1 Granite Way, Hampton" in text


def test_a_specimen_says_on_every_page_that_it_is_none_and_what_is_missing() -> None:
    grounds = _grounds(coefficients=_set(simulated=True, job={}), is_specimen=True)
    check_grounds(grounds)
    text = _text(grounds)
    assert SPECIMEN in text
    assert "the customer is not declared" in text
    assert "[job]" not in text


def test_what_nobody_declared_is_printed_without_the_keys_of_the_laboratory(tmp_path: Path) -> None:
    """In a refusal, which the laboratory reads, they stand."""
    rig = rig_file(tmp_path)
    undeclared = Undeclared(level_remarks(rig), meter_remarks(rig, rig.sensors["SN1"]))
    plain = solved_package()
    axes = {axis: replace(entry, findings=undeclared.findings) for axis, entry in plain.axes.items()}
    solved = replace(plain, axes=axes, remarks=undeclared.remarks)
    entry = build_set(solved, provenance(**{**RELEASED, "standards": (STANDARD,), "level": None}))
    text = _text(_grounds(coefficients=entry, is_specimen=True))
    assert text.count("what its zero and its gain are wrong by is in no figure stated here") >= 2
    assert "the level of the base was not read" in text
    assert not [word for word in ("declare ", "readouts.", "[level]", "[standards", "uncertainty_v") if word in text]
    assert b"declare readouts" not in to_dcc(entry)
    with pytest.raises(RequestError, match=re.escape("declare readouts.dmm.standard and uncertainty_v")):
        check_grounds(_grounds(coefficients=entry))


def test_a_calibration_that_is_not_usable_states_no_conformity_as_left() -> None:
    entry = set_not_usable()
    text = _text(_grounds(coefficients=entry, adjustment=_adjustment(entry), signed=SignOff(entry.sha256, (), ())))
    assert "As left: not judged, the calibration is not usable. Decision rule:" in text
    assert "Pitch pass" not in text


@pytest.mark.parametrize(("off_deg", "verdict"), [(0.0, "pass"), (0.0099, "conditional"), (0.02, "fail")])
def test_the_statement_of_conformity_is_that_of_the_rule(off_deg: float, verdict: str) -> None:
    entry = _set()
    # the limit is 0.01 deg, the uncertainty of this set some 1e-4 deg
    text = _text(_grounds(adjustment=_adjustment(entry, off_deg)))
    assert f"As left: {verdict}" in " ".join(text.replace(" .", ".").split())


def test_an_amendment_names_what_it_replaces_and_why() -> None:
    text = _text(_grounds(amends=Amendment("2026-0101", "wrong serial number")))
    assert "replaces certificate 2026-0101" in text
    assert "wrong serial number" in text


def test_what_else_the_work_order_says_stands_on_the_certificate_and_in_no_place_of_another() -> None:
    text = _text(_grounds(coefficients=_set(job={**JOB, "fields": {"cost centre": "30-221", "Customer": "dept. 4"}})))
    assert "cost centre 30-221" in text
    assert str(JOB["customer"]) in text
    assert "Customer dept. 4" in text


def test_declared_words_cannot_change_the_page() -> None:
    page = certificate_page(_grounds(coefficients=_set(job={**JOB, "customer": "<script>alert(1)</script>"})))
    assert "<script>" not in page
    page_tree_of(page)


def test_the_paper_is_pdf_and_the_same_again() -> None:
    grounds = _grounds()
    page = certificate_page(grounds)
    paper = certificate_paper(grounds, page, [])
    assert paper.startswith(b"%PDF-1.7")
    assert certificate_paper(grounds, certificate_page(grounds), []) == paper


def test_a_significant_finding_is_a_gap_until_somebody_accepts_it_and_then_it_is_printed() -> None:
    entry = set_with_findings()
    unaccepted = replace(_grounds().signed, findings=tuple(significant_findings(entry)))
    with pytest.raises(RequestError) as refused:
        check_grounds(_grounds(coefficients=entry, signed=unaccepted))
    assert "axis y: said of cubic. (y.cubic, which nobody has accepted)" in str(refused.value)
    assert "said of quadratic" not in str(refused.value)
    words = tuple(
        AcceptedFinding(name, "C. Reader", SIGNED, f"why {name}")
        for name in ("y.cubic", "y.wrong-dwell", "y.wrong-dwell.2")
    )
    accepted = _grounds(coefficients=entry, signed=replace(unaccepted, acceptances=words))
    check_grounds(accepted)
    assert "Axis y: said of cubic. Accepted by C. Reader, 2026-03-02 09:00:00 UTC: why y.cubic" in _text(accepted)


def test_each_gap_is_a_line_of_its_own_and_what_all_axes_show_stands_once() -> None:
    """In the refusal and in the specimen alike, though the quarantine tells the same."""
    turned = "the package turned by +72″ (u 0.39″) about roll"
    text = f"{turned}; measure them again"
    shown = tuple(StatedFinding(f"{axis}.table-rotation", axis, text, turned) for axis in "xyz")
    off = StatedFinding("y.cubic", "y", "a cubic term", "a cubic term")
    signed = replace(_grounds().signed, findings=(*shown, off), quarantine=f"the run says so; {text}")
    with pytest.raises(RequestError) as refused:
        check_grounds(_grounds(signed=signed))
    bullets = [line for line in str(refused.value).splitlines() if line.startswith("  - ")]
    gaps = [
        "the set is in quarantine: the run says so",
        f"axes x, y, z: {turned} (x.table-rotation, y.table-rotation, z.table-rotation, which nobody has accepted)",
        "axis y: a cubic term (y.cubic, which nobody has accepted)",
    ]
    assert bullets == [f"  - {gaps[0]}", f"  - {gaps[1]}; measure them again", f"  - {gaps[2]}"]
    page = certificate_page(_grounds(signed=signed, is_specimen=True))
    for gap in gaps:
        assert page.count(f"<li>{gap}</li>") == 1
    page_tree_of(page)
    alone = replace(signed, quarantine=turned)
    assert next(iter(gaps_of(_grounds(signed=alone)))) == "the set is in quarantine: what its findings say"


def test_one_person_who_reviewed_and_approved_is_told_and_two_are_not() -> None:
    """Four eyes are kept, since somebody else prepared; whoever wants six must see that they were not there."""
    signed = _grounds().signed
    for reviewer, is_told in (("b.  chief", True), ("C. Reader", False)):
        review = Signature("reviewed", reviewer, SIGNED, "")
        both = replace(signed, signatures=(signed.signatures[0], review, signed.signatures[1]))
        assert ("Reviewed and approved by one person." in _text(_grounds(signed=both))) == is_told
        assert any("who approved it reviewed it too" in line for line in sign_off_lines(both)) == is_told


def test_a_quarantine_is_a_gap_until_somebody_releases_it_and_then_it_is_printed() -> None:
    held = replace(_grounds().signed, quarantine="the table turned")
    with pytest.raises(RequestError, match="the set is in quarantine: the table turned"):
        check_grounds(_grounds(signed=held))
    text = _text(_grounds(signed=replace(held, release=Release("C. Reader", SIGNED, "a clamp, not the table"))))
    assert "in quarantine: the table turned. Released by C. Reader, 2026-03-02 09:00:00 UTC: a clamp, not the" in text


def test_what_the_laboratory_lacked_when_the_run_began_is_a_gap_that_no_signature_closes() -> None:
    lacks = f"{LACKING}axes.pitch: no standard stands behind it"
    plain = solved_package()
    entry = build_set(replace(plain, warnings=(*plain.warnings, lacks)), provenance(**RELEASED))
    with pytest.raises(RequestError, match=re.escape(lacks)):
        check_grounds(_grounds(coefficients=entry))


def test_the_range_of_temperature_of_use_and_the_reasons_of_the_verdict_stand_on_page_paper_and_dcc() -> None:
    """A reader who finds "usable" or a wide U needs what it rests on beside it, in whichever form he reads it."""
    plain = solved_package()
    reasons = {"": "3 replications only: intervals rest on 2 degrees of freedom and are wide", "x": "its output drifts"}
    used = VarianceComponent("temperature of use, offset", np.diag([1e-12, 0.0, 0.0, 0.0]), np.inf)
    of_x = replace(
        plain.axes["x"], warnings=(reasons["x"],), variance_components=(*plain.axes["x"].variance_components, used)
    )
    remarks = ("said in passing", "what bends is not in the uncertainty: add angles")
    calibration = replace(plain, axes={**plain.axes, "x": of_x}, warnings=(reasons[""],), remarks=remarks)
    entry = build_set(calibration, provenance(**{**RELEASED, "temperature_range_degc": (15.0, 25.0)}))
    grounds = _grounds(coefficients=entry, adjustment=_adjustment(entry))
    text = _text(grounds)
    assert "Valid for temperature 15.00 to 25.00 °C" in text
    assert "It counts use at 15.00 to 25.00 °C, as declared." in text
    assert re.search("Verdict of the calibration: usable ?, with the reservations below", text)
    assert f"{reasons['']}." in text
    assert f"Axis x: {reasons['x']}." in text
    assert "said in passing" not in text.lower()[text.index("Verdict of the calibration") :]
    assert "What bends is not in the uncertainty: add angles." in text
    certificate = to_dcc(entry).decode("utf-8")
    assert all(reason in certificate for reason in reasons.values())
    assert "[15.0, 25.0]" in certificate
    assert "use at" not in _text(_grounds()), "where no such part is in U"


@pytest.mark.parametrize(
    ("is_recorded", "said"),
    [
        (True, "Temperature of the sensor recorded with the readings Temperature around it not measured"),
        (False, "°C (declared; none was recorded with the readings) Temperature not measured"),
    ],
)
def test_a_temperature_that_stands_in_the_file_is_not_called_not_measured(is_recorded: bool, said: str) -> None:
    """A set from a file knows no chamber: "valid for 19.85 to 20.13 °C" stood beside "temperature not measured"."""
    changes = {"environment": {}, "temperature_range_degc": (19.85, 20.13), "temperature_recorded": is_recorded}
    text = _text(_grounds(coefficients=_set(**changes)))
    assert "Valid for temperature 19.85 to 20.13 °C" in text
    assert said in text
    assert ("Temperature not measured" in text) == (not is_recorded)


def test_a_result_over_temperature_needs_a_thermometer_with_a_certificate(tmp_path: Path) -> None:
    rig = rig_file(tmp_path)
    remarks = tuple(said.text for said in thermometer_remarks(rig, rig.sensors.values(), "estimate"))
    entry = build_set(replace(solved_package(), remarks=remarks), provenance(**RELEASED))
    with pytest.raises(RequestError, match="no uncertainty of the thermometer is declared"):
        check_grounds(_grounds(coefficients=entry))


@pytest.mark.parametrize(("beginning", "is_gap"), [(REFERENCE_NOT_MEASURED, True), (CURVATURE_UNDETERMINED, False)])
def test_results_stated_where_nothing_was_measured_are_a_gap_and_those_at_a_plateau_have_a_reservation(
    beginning: str, is_gap: bool
) -> None:
    said = f"{beginning}: and so on"
    grounds = _grounds(coefficients=build_set(replace(solved_package(), warnings=(said,)), provenance(**RELEASED)))
    assert (said in gaps_of(grounds)) == is_gap
    assert f"{said[0].upper()}{said[1:]}." in _text(grounds)
