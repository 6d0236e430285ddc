"""``calrig design``: TP's table 1 and counts through the options of the command."""

import math
from pathlib import Path

import pytest

from ams.errors import DesignError, WriteFailed
from procedures.check.design_map import plot_design
from procedures.check.evaluation import design_document, design_text, judge, write_design
from procedures.check.request import DesignRequest, requested_design
from procedures.errors import PlanError, RequestError
from procedures.plan.designs import read_points

KEYS = {"points", "pitch_points", "roll_points", "figure_of_merit_sqrt", "usage_figure_of_merit_sqrt", "max_variance"}
FRACTIONAL = "--fractional: belongs to --kind fractional, not to --kind "
FILE = "--file: belongs to --kind file, not to --kind "
REPEATED = "--repeat-roll: belongs to --roll of more than one value, which is missing"
ENDS_AND_LEVEL = ",".join(["-30"] * 16 + ["0"] + ["30"] * 16)


@pytest.mark.parametrize(
    ("request_", "calibration", "usage"),
    [  # TP table 1: V^1/2 over the calibration range, V_R^1/2 over the usage range; M = 64, N = 33
        (DesignRequest("D1", pitch="-30:30:33", roll="64"), 1.989, None),
        (DesignRequest("D1", pitch="-45:45:33", roll="64", usage="-30:30"), 1.993, 1.927),
        (DesignRequest("D1", pitch="-90:90:33", roll="64", usage="-30:30"), 2.008, 2.222),
        (DesignRequest("D1", pitch="-180:180:33", roll="64", usage="-30:30"), 1.993, 2.174),
        (DesignRequest("D0", pitch_list=ENDS_AND_LEVEL, roll="64", usage="-10:10"), 1.941, 1.912),
        (DesignRequest("D1", pitch="-30:30:33", roll="64", repeat_roll=True), 1.989, None),
    ],
)
def test_figures_of_merit_are_those_of_tp_table_1(request_, calibration, usage):
    document = design_document(judge(request_))
    assert document["figure_of_merit_sqrt"] == pytest.approx(calibration, abs=1e-3)
    assert document["usage_figure_of_merit_sqrt"] == (None if usage is None else pytest.approx(usage, abs=1e-3))


@pytest.mark.parametrize(
    ("pitch", "roll", "every", "points"),
    [("-90:90:19", "12", "3,4", 139), ("-30:30:5", "12", "2,2", 53), ("-180:180:13", "6", "2,2", 73)],
)
def test_fractional_designs_have_the_printed_counts(pitch, roll, every, points):
    document = design_document(judge(DesignRequest(pitch=pitch, roll=roll, repeat_roll=True, fractional=every)))
    assert document["points"] == points
    assert (document["pitch_points"], document["roll_points"]) == (int(pitch.split(":")[2]), int(roll) + 1)


@pytest.mark.parametrize(("roll", "points", "variance"), [(None, 6, 2 / 3), ("1", 4, 3 / 4)])
def test_the_tumbles_have_the_same_variance_everywhere(roll, points, variance):
    document = design_document(judge(DesignRequest("T", roll=roll)))
    assert document["points"] == points
    assert document["max_variance"] == pytest.approx(variance, abs=1e-12)
    assert document["figure_of_merit_sqrt"] == pytest.approx(math.sqrt(points * variance), abs=1e-9)


def test_the_document_has_exactly_the_keys_that_were_promised():
    assert set(design_document(judge(DesignRequest(pitch="-45:45:33", roll="64")))) == KEYS


def test_a_range_by_step_is_exact_in_decimals():
    design = requested_design(DesignRequest(pitch="-90/90/10", roll="-180/180/30"))
    assert design.pitch_values_deg == tuple(float(angle) for angle in range(-90, 91, 10))
    assert len(design.points) == 247
    assert requested_design(DesignRequest(pitch="-1/1/0.1")).pitch_values_deg[13] == 0.3


def test_any_design_can_be_asked_for_with_any_sets():
    design = requested_design(DesignRequest("D", pitch_list="0,10,35", roll="-90:90:3"))
    assert [(p.pitch_deg, p.roll_deg) for p in design.points[:4]] == [(0, -90), (0, 0), (0, 90), (10, -90)]


@pytest.mark.parametrize(
    ("request_", "sentence"),
    [
        (DesignRequest(), r"give either --pitch=from:to:count or --pitch-list"),
        (DesignRequest(pitch="1:2", pitch_list="3"), r"give either --pitch"),
        (DesignRequest(pitch="-45:45"), r"--pitch: got '-45:45', allowed from:to:count such as -45:45:33"),
        (DesignRequest(pitch="-45:45:x"), r"--pitch: got '-45:45:x'"),
        (DesignRequest(pitch="-45:45:nan"), r"--pitch: got '-45:45:nan'"),
        (DesignRequest(pitch="-45:45:2.5"), r"--pitch: got '-45:45:2.5'"),
        (DesignRequest(pitch="45:-45:3"), r"from must not exceed to"),
        (DesignRequest(pitch="-90/90/7"), r"not a whole number of steps"),
        (DesignRequest(pitch="-30:30:3", roll="1.5"), r"--roll: got '1.5', allowed a whole number"),
        (DesignRequest(pitch="-30:30:3", roll="0"), r"--roll: got '0'"),
        (DesignRequest("D2", pitch="-30:30:3"), r"--kind: got 'D2', allowed D, D0, D1, T, factorial, file, fractional"),
        (DesignRequest("fractional", pitch="-30:30:3"), r"--fractional: is missing"),
        (DesignRequest(pitch="-30:30:3", fractional="3"), r"--fractional: got '3', allowed Ka,KR"),
        (DesignRequest(pitch="-30:30:3", roll="4", usage="30:-30"), r"--usage: got '30:-30'"),
        (DesignRequest("T", pitch="-30:30:3"), r"--pitch: has no meaning beside --kind T"),
        (DesignRequest("file"), r"--file: is missing"),
        (DesignRequest("D1", pitch="-30:30:5", roll="8", fractional="1,1"), FRACTIONAL + "D1"),
        (DesignRequest("D0", pitch_list="-30,0,30", roll="8", fractional="2,2"), FRACTIONAL + "D0"),
        (DesignRequest("T", fractional="2,2"), FRACTIONAL + "T"),
        (DesignRequest("D1", pitch="-30:30:5", roll="8", file=Path("p.csv")), FILE + "D1"),
        (DesignRequest("D0", pitch_list="-30,0,30", roll="8", file=Path("p.csv")), FILE + "D0"),
        (DesignRequest("T", file=Path("p.csv")), FILE + "T"),
        (DesignRequest(pitch="-30:30:5", roll="8", fractional="2,2", file=Path("p.csv")), FILE + "fractional"),
        (DesignRequest(file=Path("p.csv"), pitch="-30:30:5"), r"--pitch: has no meaning beside --file"),
        (
            DesignRequest("T", repeat_roll=True),
            r"--repeat-roll: belongs to --kind D, D0, D1, factorial or fractional, not to",
        ),
        (DesignRequest(pitch="-30:30:5", repeat_roll=True), REPEATED),
        (DesignRequest(pitch="-30:30:5", roll="1", repeat_roll=True), REPEATED),
    ],
)
def test_wrong_options_are_refused_by_name(request_, sentence):
    with pytest.raises(RequestError, match=sentence):
        judge(request_)


def test_a_design_that_cannot_determine_its_model_is_refused():
    with pytest.raises(DesignError, match="k_y_v_per_g"):
        judge(DesignRequest("D", pitch="-30:30:3", roll="-180:0:2"))
    with pytest.raises(PlanError, match="uniform and symmetric"):
        judge(DesignRequest(pitch="-30:20:6", roll="8"))


def test_points_written_are_points_read(tmp_path: Path):
    judged = judge(DesignRequest(pitch="-90:90:19", roll="12", repeat_roll=True, fractional="3,4"))
    write_design(judged, tmp_path / "points.csv")
    assert read_points(tmp_path / "points.csv").points == judged.design.points
    assert len((tmp_path / "points.csv").read_text(encoding="utf-8").splitlines()) == 140


def test_the_map_is_drawn_as_svg_png_or_pdf_and_is_the_same_every_time(tmp_path: Path):
    judged = judge(DesignRequest(pitch="-45:45:7", roll="8", usage="-30:30"))
    for ending in ("svg", "png", "pdf"):
        for name in ("one", "two"):
            plot_design(judged, tmp_path / f"{name}.{ending}")
        assert (tmp_path / f"one.{ending}").read_bytes() == (tmp_path / f"two.{ending}").read_bytes()
    assert (tmp_path / "one.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "one.pdf").read_bytes().startswith(b"%PDF")
    plot_design(judge(DesignRequest("T", roll="1")), tmp_path / "tumble.svg")


def test_a_map_that_cannot_be_written_is_told(tmp_path: Path):
    judged = judge(DesignRequest(pitch="-45:45:7", roll="8"))
    with pytest.raises(
        RequestError, match=r"--plot: got 'map\.txt', allowed are names that end in \.svg, \.png, \.pdf"
    ):
        plot_design(judged, tmp_path / "map.txt")
    with pytest.raises(WriteFailed, match="cannot be written"):
        plot_design(judged, tmp_path / "nowhere" / "map.svg")


def test_the_text_says_what_the_document_says():
    text = design_text(judge(DesignRequest(pitch="-45:45:33", roll="64", usage="-30:30")))
    assert "2112 points, 33 pitch × 64 roll" in text
    assert "1.993" in text
    assert "use from -30° to 30°   1.927" in text
