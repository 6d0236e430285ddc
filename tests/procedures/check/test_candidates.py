"""Laws of ``calrig plan``: what is chosen reaches the target, nothing quicker does, and its file is as promised."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from command import call
from example_files import EXAMPLE_RIG
from planning_files import rig_file
from rich.console import Console

from procedures.check.candidate import Comparison, SearchRange, SearchRequest, Target
from procedures.check.candidate_file import chosen_procedure, what_holds_it
from procedures.check.candidates import IN_HAND, compare
from procedures.check.candidates_text import render_comparison
from procedures.check.check_report import check
from procedures.errors import PlanError
from procedures.kinds.read import procedure_of
from procedures.solution.expected import Usage
from rig.description.read import read_rig
from rig.toml_file import TomlFile

SMALL = SearchRange(grids=((5, 6), (7, 8)), fractions=(), optimal=(), replications=(3, 6), samples=(5, 20))
USAGE = Usage((-30.0, 30.0))


def compared(target: Target, space: SearchRange = SMALL, usage: Usage = USAGE) -> Comparison:
    return compare(SearchRequest(read_rig(EXAMPLE_RIG), target, usage, space=space))


@pytest.fixture(scope="module")
def best() -> Comparison:
    return compared(Target(hours=100.0))


def test_the_chosen_one_reaches_the_target_and_nothing_quicker_does(best: Comparison) -> None:
    wanted = best.candidates[best.front[2]].half_width_deg * IN_HAND * 1.0001
    chosen = (found := compared(Target(half_width_deg=wanted))).candidates[found.chosen]
    assert IN_HAND * chosen.half_width_deg <= wanted
    quicker = [other for other in found.candidates if other.hours < chosen.hours and not other.is_confounded]
    assert all(IN_HAND * other.half_width_deg > wanted for other in quicker)


def test_the_hours_that_there_are_are_not_exceeded_and_nothing_within_them_is_better(best: Comparison) -> None:
    chosen = (found := compared(Target(hours=2.0))).candidates[found.chosen]
    assert chosen.hours <= 2.0
    allowed = [candidate for candidate in found.candidates if candidate.hours <= 2.0 and not candidate.is_confounded]
    assert min(entry.half_width_deg for entry in allowed) == chosen.half_width_deg
    assert [candidate.hours for candidate in best.candidates] == sorted(
        candidate.hours for candidate in best.candidates
    )


def test_more_readings_and_more_replications_cost_hours_and_leave_less(best: Comparison) -> None:
    plain = [
        candidate for candidate in best.candidates if candidate.nplc is None and candidate.order == "there-and-back"
    ]
    by_choice = {(entry.points, entry.replications, entry.samples): entry for entry in plain}
    for (points, replications, samples), candidate in by_choice.items():
        for more in ((points, 6, samples), (points, replications, 20)):
            if more != (points, replications, samples):
                assert by_choice[more].hours > candidate.hours
                assert by_choice[more].half_width_deg < candidate.half_width_deg


def test_the_file_passes_check_and_is_what_was_promised(best: Comparison) -> None:
    chosen = best.candidates[best.chosen]
    text = chosen_procedure(best)
    report = check(best.request.rig, procedure_of(TomlFile(Path("procedure.toml"), text)))
    angles = report.forecast.angles["SN1047"]
    assert report.plan.expected.p50_s / 3600.0 == pytest.approx(
        chosen.hours, rel=0.03
    )  # reference visits run on through replications
    assert max(angle.u95_deg for angle in angles.values()) == pytest.approx(chosen.half_width_deg, rel=0.01)
    assert "# It cannot see: lack of fit below" in text
    (other,) = (
        candidate
        for candidate in best.candidates
        if (candidate.design, candidate.replications, candidate.samples) == (chosen.design, chosen.replications, 5)
        and candidate.nplc is None
    )
    assert f"# 5 readings would take {other.hours:.2f} h and leave U95 {3600.0 * other.half_width_deg:.3g}" in text


def test_a_chamber_that_the_choice_sets_to_nothing_is_told_in_file_and_table(
    best: Comparison, capsys: pytest.CaptureFixture[str]
) -> None:
    """The reader of the screen sees the table's name, in the brackets that mean bold to rich."""
    assert "Nothing here sets the temperature of air" in chosen_procedure(best)
    Console(width=200).print(render_comparison(best))
    assert "a table [environment] with plateaus_degc" in capsys.readouterr().out


def test_every_row_says_its_design_and_what_check_will_hold_against_it(
    best: Comparison, capsys: pytest.CaptureFixture[str]
) -> None:
    """No two rows are alike to the eye, and two or three replications are marked as check would."""
    Console(width=200).print(render_comparison(best))
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if re.search(r"\d×\d+\*?×\d", line)]
    assert len({tuple(row.removeprefix("→").split()[:5]) for row in rows}) == len(rows) > 3
    few = [row for row in rows if re.search(r"\d×[23]\D", row)]
    assert all(re.search(r"\d×[23]\*×", row) for row in few)
    assert sum("*" in row for row in rows) == len(few)
    assert any("*: a reservation of check and report" in line for line in lines) == bool(few)


def test_a_serpentine_is_quick_and_never_chosen_and_forward_reverse_counts_every_visit(best: Comparison) -> None:
    """The report would say that a drift passes for a parameter; twice the points take about twice the time."""
    alike = {
        candidate.order: candidate
        for candidate in best.candidates
        if (candidate.replications, candidate.samples, candidate.nplc, candidate.points)
        in {(3, 5, None, 30), (3, 5, None, 60)}
    }
    assert alike["serpentine"].hours <= 1.1 * min(entry.hours for entry in alike.values())
    assert alike["serpentine"].is_confounded
    assert not alike["there-and-back"].is_confounded
    assert all(not best.candidates[location].is_confounded for location in best.front)
    assert alike["forward-reverse"].points == 60
    assert 1.5 < alike["forward-reverse"].hours / alike["serpentine"].hours < 2.2


def test_sensors_on_the_table_at_once_share_the_moves_and_leave_no_more_unknown(tmp_path: Path) -> None:
    rig = read_rig(EXAMPLE_RIG)
    four = rig.model_copy(update={"sensors": {f"SN{index}": rig.sensors["SN1047"] for index in range(4)}})
    small = replace(SMALL, replications=(3,), samples=(5,), orders=("there-and-back",))
    found = compare(SearchRequest(four, Target(hours=100.0), USAGE, space=small))
    chosen = found.candidates[found.chosen]
    assert chosen.sensors == found.sensors == 4
    others = [
        candidate
        for candidate in found.candidates
        if (candidate.points, candidate.nplc) == (chosen.points, chosen.nplc)
    ]
    assert {other.sensors: other.hours > chosen.hours for other in others} == {1: True, 2: True, 4: False}
    assert {other.half_width_deg for other in others} == {chosen.half_width_deg}
    assert all(other.hours == pytest.approx(4 // other.sensors * other.run_hours) for other in others)


def test_what_is_out_of_reach_is_a_sentence_with_the_nearest_possible(best: Comparison) -> None:
    with pytest.raises(PlanError, match=r"out of reach: with 10 % in hand the nearest is 0\.000\d+° in .* h"):
        compared(Target(half_width_deg=1e-6))
    with pytest.raises(
        PlanError, match=r"half-width of 0\.002 µV of offset_v is out of reach: .* is [\d.]+ µV in .* h"
    ):
        compared(Target(parameter=("offset_v", 2e-9)))
    with pytest.raises(PlanError, match=r"the shortest calibration that can be solved takes 0\.\d+ h") as short:
        compared(Target(hours=0.01))
    said = re.search(r"takes (\S+) h", str(short.value))
    assert said is not None
    enough = compared(Target(hours=float(said[1])))  # who gives as many hours as the sentence says is not refused again
    assert not enough.candidates[enough.chosen].is_confounded
    with pytest.raises(PlanError, match=r"--parameter: got 'b', the sensors have offset_v"):
        compared(Target(parameter=("b", 1.0)))
    with pytest.raises(PlanError, match=r"--usage-pitch: got 20 to -20"):
        compared(Target(hours=1.0), usage=Usage((20.0, -20.0)))
    with pytest.raises(PlanError, match="no sensor that measures acceleration"):
        compare(replace(best.request, rig=best.request.rig.model_copy(update={"sensors": {}})))


def test_a_table_that_stops_at_few_angles_is_asked_for_no_others(tmp_path: Path) -> None:
    rig = rig_file(tmp_path, ("increment_deg = 1.0", "increment_deg = 15.0"))
    found = compare(SearchRequest(rig, Target(hours=100.0), USAGE, space=SMALL))
    for candidate in found.candidates:
        assert all(angle % 15.0 == 0.0 for angle in candidate.design["pitch_deg"])


def test_a_list_of_the_tables_errors_is_planned_at_its_angles_and_leaves_less_unknown(
    tmp_path: Path, best: Comparison
) -> None:
    """What lies between listed angles is as unknown as without a list: nine pitches over ±45° are none of its own."""
    rows = "".join(f"{angle},0.3,0.1\n" for angle in range(-180, 180, 15))
    (tmp_path / "list.csv").write_text(f"angle_deg,error_arcsec,uncertainty_arcsec\n{rows}", encoding="utf-8")
    text = EXAMPLE_RIG.read_text(encoding="utf-8").replace(
        "speed_dps = 5.0", 'speed_dps = 5.0\nindex_table = "list.csv"'
    )
    (tmp_path / "rig.toml").write_text(text, encoding="utf-8")
    space = replace(SMALL, grids=((9, 8),))
    listed = compare(replace(best.request, rig=read_rig(tmp_path / "rig.toml"), space=space))
    chosen = listed.candidates[listed.chosen]
    angles = (*chosen.design["pitch_deg"], *chosen.design["roll_deg"])  # type: ignore[misc]
    assert all(angle % 15.0 == 0.0 for angle in angles)
    others = [
        candidate for candidate in listed.candidates if candidate.design["pitch_deg"] != chosen.design["pitch_deg"]
    ]
    assert min(other.calibration_deg for other in others) > 1.5 * chosen.calibration_deg
    plain = compare(replace(best.request, space=space))
    assert chosen.calibration_deg < 0.5 * plain.candidates[plain.chosen].calibration_deg
    helps = "a certificate that lists the errors of pitch and roll"
    assert any(helps in line for line in what_holds_it(plain, plain.candidates[plain.chosen]))
    assert not any(helps in line for line in what_holds_it(listed, chosen))


def test_the_shares_of_a_candidate_are_all_of_it(best: Comparison) -> None:
    for candidate in best.candidates:
        squares = sum(share * abs(share) for share in candidate.shares_deg.values())
        assert squares == pytest.approx(candidate.half_width_deg**2)


@pytest.mark.thorough
def test_the_command_writes_file_picture_and_document(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("procedures.cli.prepare.plan.SEARCH_RANGE", SMALL)
    out, plot = tmp_path / "p.toml", tmp_path / "p.svg"
    options = ("--rig", EXAMPLE_RIG, "--hours", "2", "--usage-pitch=-30:30")
    document = call(capsys, "plan", *options, "--out", out, "--plot", plot, "--json").document
    chosen = document["candidates"][document["chosen"]]
    assert set(chosen) >= {"points", "replications", "samples", "nplc", "order", "hours", "half_width_deg"}
    assert json.dumps(document, allow_nan=False)
    assert plot.read_bytes().startswith(b"<?xml")
    assert call(capsys, "check", out, "--rig", EXAMPLE_RIG, "--json").status == 0
    assert "is there already" in call(capsys, "plan", *options, "--out", out).err
    assert "give one of --half-width-deg" in call(capsys, "plan", "--rig", EXAMPLE_RIG).err
