"""``calrig check``: what it tells about a plan, against numbers worked out by hand and by simulation."""

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from command import call
from example_files import EXAMPLE_PROCEDURE, EXAMPLE_RIG, changed
from planning_files import AIR, PROCEDURE, RIG, procedure_file, rig_file
from rich.console import Console

from procedures.check.check_report import check, to_document
from procedures.check.check_text import render
from procedures.kinds.expected import ExpectedAxis
from rig.errors import DescriptionError
from rig.local_time import at_both

NOW = datetime(2026, 3, 1, 16, 30, tzinfo=UTC)
BIG = [
    ("from = -30.0, to = 30.0, step = 10.0", "from = -90.0, to = 90.0, step = 10.0"),
    ("step = 90.0", "step = 30.0"),
    ("replications = 2", "replications = 6"),
]
TWIN = """
[twin]
seed = 1
[twin.truth.SN1.x]
offset_v = 0.0
sensitivity_v_per_g = 2.5
coning_deg = 1.0
azimuth_deg = 30.0
noise_v = 4e-5
[twin.truth.SN1.y]
offset_v = 0.0
sensitivity_v_per_g = 2.5
[twin.truth.SN1.z]
offset_v = 0.0
sensitivity_v_per_g = 2.5
noise_v = 4e-5
"""


def test_counts_limits_rank_and_degrees_of_freedom(tmp_path: Path):
    document = to_document(
        check(rig_file(tmp_path), procedure_file(tmp_path, *BIG, more="[check]\nreference_every = 25\n"))
    )
    assert document["points"] == 247
    assert document["design_dwells"] == 1482
    assert document["dwells_planned"] == 1482 + 6 + 59
    assert document["axes"]["pitch"]["reached_deg"] == [-90.0, 90.0]
    assert document["axes"]["roll"]["limits_deg"] == [-180.0, 180.0]
    assert document["rank"] == len(document["parameters"]) == 10
    assert document["degrees_of_freedom"] == 1472
    assert ["a lone sensor" in entry for entry in document["advice"]] == [True, False]


def test_the_document_is_strict_json(tmp_path: Path):
    document = to_document(check(rig_file(tmp_path), procedure_file(tmp_path)))
    assert json.loads(json.dumps(document, allow_nan=False)) == document


def test_time_hardly_correlates_there_and_back_and_does_in_a_serpentine(tmp_path: Path):
    rig = rig_file(tmp_path)
    assert check(rig, procedure_file(tmp_path, *BIG)).forecast.design.time_correlation < 0.1
    assert (
        check(rig, procedure_file(tmp_path, *BIG, more='order = "serpentine"\n')).forecast.design.time_correlation > 0.9
    )


@pytest.mark.parametrize("step_deg", [15.0, 30.0, 45.0, 60.0, 90.0])
def test_errors_of_roll_that_every_point_has_alike_are_told_with_their_period(tmp_path: Path, step_deg: float):
    """An encoder of so many waves is the same at all rolls of the design, and one of a wave less is not."""
    document = to_document(check(rig_file(tmp_path), procedure_file(tmp_path, ("step = 90.0", f"step = {step_deg}"))))
    roll = np.radians(np.arange(-180.0, 180.0, step_deg))
    waves = 360.0 / document["roll_errors_alike_every_deg"]
    assert np.ptp(np.sin(waves * roll + 1.0)) < 1e-9
    assert all(np.ptp(np.sin(fewer * roll + 1.0)) > 0.1 for fewer in np.arange(1.0, waves))


def test_rolls_in_no_even_steps_have_no_such_errors(tmp_path: Path):
    rolls = ("roll_deg = { from = -180.0, to = 180.0, step = 90.0 }", "roll_deg = [-180.0, -90.0, 2.0, 93.0]")
    kind = ('kind = "D1"', 'kind = "D"')
    document = to_document(check(rig_file(tmp_path), procedure_file(tmp_path, kind, rolls)))
    assert document["roll_errors_alike_every_deg"] is None


def test_a_stated_noise_is_taken_before_the_twins_and_half_an_arc_second_without_either(tmp_path: Path):
    arcsec_v = 2.5 * np.deg2rad(1.0 / 3600.0)
    stated = procedure_file(tmp_path, more="[solve]\nexpected_noise_arcsec = 2.0\n")
    rig = rig_file(tmp_path)
    assert check(rig, stated).forecast.expected[0].noise_v == pytest.approx(2.0 * arcsec_v)
    assert check(rig, procedure_file(tmp_path)).forecast.expected[0].noise_v == pytest.approx(0.5 * arcsec_v)
    twins = rig_file(tmp_path, ('"socket://127.0.0.1:1"', '"twin"'), more=TWIN)
    assert check(twins, procedure_file(tmp_path)).forecast.expected[0].noise_v == pytest.approx(4e-5 / np.sqrt(20))
    assert check(twins, stated).forecast.expected[0].noise_v == pytest.approx(2.0 * arcsec_v)


def test_what_is_expected_of_the_angles_is_told_with_its_shares_and_their_squares_add_up(tmp_path: Path):
    rig = rig_file(tmp_path, ('"socket://127.0.0.1:1"', '"twin"'), more=TWIN)
    document = to_document(check(rig, procedure_file(tmp_path, more="usage_pitch_deg = [-20.0, 20.0]\n")))
    half, shares = (document[f"expected_angle_{key}_deg"]["SN1"] for key in ("half_width", "shares"))
    assert set(half) == {"pitch", "roll"}
    for name, u95_deg in half.items():
        squares = sum(np.sign(share) * share**2 for share in shares[name].values())
        assert squares == pytest.approx(u95_deg**2), name
        assert "reading at use" in shares[name]
    assert document["usage_pitch_deg"] == [-20.0, 20.0]
    assert any("two replications" in entry or "2 replications only" in entry for entry in document["reservations"])


def test_a_stated_noise_at_use_is_what_the_angles_are_read_with(tmp_path: Path):
    """At rest pitch is read by x alone near level: one reading of 7 arc seconds leaves 1.96 times as much."""
    rig = rig_file(
        tmp_path, ('"socket://127.0.0.1:1"', '"twin"'), more=TWIN.replace("noise_v = 4e-5", "noise_v = 1e-8")
    )
    used = "usage_pitch_deg = [-2.0, 2.0]\nusage_noise_arcsec = 7.0\n"
    (angles,) = check(rig, procedure_file(tmp_path, more=used)).forecast.angles.values()
    assert angles["pitch"].u95_deg * 3600.0 == pytest.approx(1.96 * 7.0, rel=0.01)
    assert angles["pitch"].calibration_deg < 0.01 * angles["pitch"].u95_deg


def test_without_coning_the_azimuth_will_not_be_determined(tmp_path: Path):
    rig = rig_file(tmp_path, ('"socket://127.0.0.1:1"', '"twin"'), more=TWIN)
    z = next(axis for axis in check(rig, procedure_file(tmp_path)).forecast.expected if axis.axis == "z")
    assert z.standard_uncertainty["azimuth_deg"] is None
    assert z.standard_uncertainty["coning_deg"] is None
    assert z.standard_uncertainty["offset_v"] > 0.0


def test_advice_names_the_recommendation_that_is_not_followed(tmp_path: Path):
    rig = rig_file(tmp_path)

    def advice(*changes, more=""):
        return " ".join(check(rig, procedure_file(tmp_path, *changes, more=more)).advice)

    assert "recommendation 6" in advice()
    assert "recommendation 1" in advice(more="usage_pitch_deg = [-25.0, 25.0]\n")
    assert "recommendation 1" not in advice(more="usage_pitch_deg = [-20.0, 20.0]\n")
    assert "reaches beyond the calibration" in advice(more="usage_pitch_deg = [-40.0, 40.0]\n")
    assert "recommendation 2" in advice(('"D1"', '"D"'), ("from = -180.0, to = 180.0", "from = -90.0, to = 90.0"))


def test_advice_tells_an_order_that_lets_what_comes_back_pass_for_the_sensor(tmp_path: Path):
    rig, passes = rig_file(tmp_path), "what comes back with each (hum of the mains"

    def told(order: str, *changes) -> list[str]:
        ordered = procedure_file(tmp_path, ('kind = "D1"', f'kind = "D1"\norder = "{order}"'), *changes)
        return [entry for entry in check(rig, ordered).advice if passes in entry]

    assert len(told("there-and-back")) == len(told("raster")) == 1
    assert not told("neighbours")
    assert not told("random")
    assert not told("there-and-back", ("replications = 2", "replications = 1"))


def test_every_part_is_printed(tmp_path: Path):
    more = "[environment]\nplateaus_degc = [20.0]\n"
    report = check(rig_file(tmp_path, more=AIR), procedure_file(tmp_path, more=more))
    console = Console(width=140, record=True, file=(tmp_path / "out").open("w", encoding="utf-8"))
    console.print(render(report, NOW))
    console.file.close()
    text = console.export_text()
    for seconds in (report.plan.expected.p50_s, report.plan.expected.p90_s):
        moment = NOW + timedelta(seconds=seconds)
        assert at_both(moment) in text
    together = " ".join(text.split())
    for one in report.forecast.recommendations:
        assert one.reason in together
    assert [one.number for one in report.forecast.recommendations] == list(range(1, 11))
    for piece in (
        "35 points (7 pitch × 5 roll)",
        "(p50: half of such runs take longer)",
        "20 °C by air",
        "4 of 4",
        "U95",
        "-180 to 180",
        "u(azimuth)",
        "SN1 z",
    ):
        assert piece in text, piece


def test_noise_and_coning_that_differ_between_axes_are_told_with_the_axes(tmp_path: Path):
    report = check(rig_file(tmp_path), procedure_file(tmp_path))
    still, drifting = "2e-05 V a reading; no lack of fit and no drift assumed", "2e-05 V a reading; the twin's drift"
    expected = [
        replace(axis, coning_deg=coning_deg, noise_source=source)
        for axis, coning_deg, source in zip(
            report.forecast.expected, (0.5, 0.11, 0.3), (still, drifting, still), strict=True
        )
    ]

    def told(axes: list[ExpectedAxis]) -> str:
        out = StringIO()
        forecast = replace(report.forecast, expected=axes)
        Console(width=200, file=out).print(render(replace(report, forecast=forecast)))
        return out.getvalue()

    first, second, third = (axis.axis for axis in expected)
    text = told(expected)
    assert f"noise:\n  SN1 {first}, {third}: {still}\n  SN1 {second}: {drifting}\n" in text
    assert f"the coning angle of each axis, from 0.11° (SN1 {second}) to 0.5° (SN1 {first}), and goes as" in text
    alike = told([replace(axis, coning_deg=0.5, noise_source=still) for axis in expected])
    assert f"(noise: {still})\nu(azimuth) holds for the coning angle of 0.5°, and goes as its inverse\n" in alike


def test_uncertainties_over_temperature_stand_whole_at_eighty_columns(tmp_path: Path) -> None:
    more = (
        '[environment]\nplateaus_degc = [20.0, 0.0, 40.0]\n[solve]\ntemperature = "estimate"\ntemperature_order = 2\n'
    )
    report = check(rig_file(tmp_path, more=AIR), procedure_file(tmp_path, ("replications = 2", ""), more=more))
    out = StringIO()
    Console(width=80, file=out).print(render(report))
    rows = [line.split() for line in out.getvalue().splitlines() if line.strip().startswith("SN1 y ")]
    stated = next(axis for axis in report.forecast.expected if axis.axis == "y").standard_uncertainty
    curved = [value for name, value in stated.items() if "_tc" in name]
    assert len(curved) == 4
    assert [float(cell) for cell in rows[1][2:]] == pytest.approx(
        [curved[0] * 1e6, curved[1], curved[2] * 1e6, curved[3]], rel=5e-3
    )


@pytest.mark.parametrize(("half_width_deg", "is_foreseen"), [(0.1, True), (1e-6, False)])
def test_a_rule_to_stop_is_told_and_one_that_is_never_met_too(
    tmp_path: Path, half_width_deg: float, is_foreseen: bool
) -> None:
    rule = f"[stop]\nhalf_width_deg = {half_width_deg}\nleast_replications = 2\nmost_replications = 5\n"
    procedure = procedure_file(tmp_path, ("replications = 2\n", ""), more=rule)
    report = check(rig_file(tmp_path), procedure)
    with (tmp_path / "out").open("w", encoding="utf-8") as out:
        Console(width=200, file=out).print(render(report))
    told = " ".join((tmp_path / "out").read_text(encoding="utf-8").split())
    assert "may end early from 2 of 5 replications on" in told
    assert f"at most {half_width_deg * 3600.0:.3g}″ ([stop])" in told
    assert ("is not expected to be reached: after all 5 replications" in told) is not is_foreseen


def test_a_run_that_ends_early_takes_as_long_as_one_of_so_few_replications(tmp_path: Path) -> None:
    """The soak is waited for once: a share of the whole run would be too short."""
    rig = rig_file(tmp_path, more=AIR)
    soaked = "[environment]\nplateaus_degc = [20.0]\nsoak_s = 3600.0\n"
    rule = "[stop]\nhalf_width_deg = 0.1\nleast_replications = 2\nmost_replications = 8\n"
    report = check(rig, procedure_file(tmp_path, ("replications = 2\n", ""), more=soaked + rule))
    alone = check(rig, procedure_file(tmp_path, more=soaked))
    assert report.earliest is not None
    assert report.earliest.p50_s == pytest.approx(alone.plan.expected.p50_s, rel=1e-9)
    assert report.earliest.p50_s > 0.25 * report.plan.expected.p50_s + 2000.0
    assert alone.earliest is None


def test_without_roll_the_check_speaks_of_the_model_without_roll(tmp_path: Path):
    rig = rig_file(
        tmp_path, ('"three-axis package"', '"single-axis package"'), (', y = "dmm.y", z = "dmm.z" }\nnom', " }\nnom")
    )
    roll = PROCEDURE.splitlines()[-1]
    report = check(rig, procedure_file(tmp_path, (roll, ""), more='[solve]\nmodel = "pitch-only"\n'))
    assert report.forecast.design.rank == 3
    assert set(report.forecast.expected[0].standard_uncertainty) == {
        "offset_v",
        "sensitivity_v_per_g",
        "pitch_misalignment_deg",
    }
    assert "socket" in RIG


@pytest.mark.parametrize(
    ("attitudes", "is_told"),
    [
        ("", True),
        ("pitch_deg = [0.0, 30.0]\n", True),
        ("pitch_deg = [0.0, 0.0]\nroll_deg = [0.0, 60.0]\n", True),
        ("pitch_deg = [0.0, 30.0]\nroll_deg = [0.0, 60.0]\n", False),
    ],
)
def test_reference_visits_that_cannot_tell_a_slip_from_a_tilt_are_told(
    tmp_path: Path, attitudes: str, is_told: bool
) -> None:
    more = f"[check]\nreference_every = 7\n{attitudes}"
    advice = check(rig_file(tmp_path), procedure_file(tmp_path, more=more)).advice
    assert any("cannot tell a slip of the table" in entry for entry in advice) == is_told


def test_reference_attitudes_that_are_not_pairs_are_refused_in_a_sentence(tmp_path: Path) -> None:
    more = "[check]\nreference_every = 7\npitch_deg = [0.0, 30.0]\nroll_deg = [0.0, 10.0, 20.0]\n"
    with pytest.raises(DescriptionError, match="give one number, or two lists of the same length"):
        check(rig_file(tmp_path), procedure_file(tmp_path, more=more))


def test_a_machine_without_a_stop_is_named_with_and_without_a_procedure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = changed(
        EXAMPLE_RIG,
        'driver = "indexing-table"',
        'driver = "indexing-table"\ndialect = "inficon-srt-422"',
        tmp_path / "r.toml",
    )
    procedure = EXAMPLE_PROCEDURE
    for old, new in {  # angles that its counts of 0.18° tell
        "pitch_deg = { from = -90.0, to = 90.0, step = 10.0 }": "pitch_deg = { from = 0.0, to = 90.0, step = 18.0 }",
        "roll_deg = { from = -180.0, to = 180.0, step = 30.0 }": "roll_deg = { from = 0.0, to = 180.0, step = 36.0 }",
        'kind = "D1"': 'kind = "D"',
        "usage_pitch_deg = [-60.0, 60.0]": "usage_pitch_deg = [0.0, 60.0]",
        "pitch_deg = [0.0, 30.0]": "pitch_deg = [0.0, 36.0]",
        "roll_deg = [0.0, 60.0]": "roll_deg = [0.0, 54.0]",
    }.items():
        procedure = changed(procedure, old, new, tmp_path / "p.toml")
    for files in ((), (procedure,)):
        outcome = call(capsys, "check", *files, "--rig", rig).out
        assert "axis pitch: dialect inficon-srt-422: it cannot be stopped" in " ".join(outcome.split())
    document = call(capsys, "check", procedure, "--rig", rig, "--json").document
    assert "it cannot be stopped" in document["machines"]["pitch"][0]


def test_an_order_that_visits_every_attitude_twice_says_so(tmp_path: Path) -> None:
    for order, counts in {"forward-reverse": "70 points (7 pitch × 5 roll, each attitude visited twice)",
                          "serpentine": "35 points (7 pitch × 5 roll)"}.items():  # fmt: skip
        report = check(rig_file(tmp_path), procedure_file(tmp_path, more=f'order = "{order}"\n'))
        with (tmp_path / "out").open("w", encoding="utf-8") as out:
            Console(width=200, file=out).print(render(report))
        assert f"{counts}, order {order}" in (tmp_path / "out").read_text(encoding="utf-8")
