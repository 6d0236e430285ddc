"""What ``calrig fit`` and ``calrig solve`` tell beyond the numbers, as a user asks for it, also wrongly."""

import csv
import json
import re
import tomllib
from collections.abc import Callable
from datetime import UTC, date, datetime
from pathlib import Path

import calrig
import numpy as np
import pytest
from command import call
from example_files import EXAMPLE_RIG
from package_outputs import TRUTH, write_observations
from planning_files import rig_file

from ams.archive.sign_offs import SignOff
from ams.errors import ObservationsError
from ams.exports.formats import load_set
from ams.sets.stated_findings import TABLE_NOT_COUNTED, outside_uncertainty
from ams.sets.verdict_conditions import NO_CROSSTALK, NO_GRAVITY, NO_LEVEL, NO_METER, NO_TEMPERATURE
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.errors import RequestError
from procedures.run.readiness import readiness
from rig.description.read import read_rig
from rig.errors import DescriptionError
from rig.local_time import local_day

AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
DRIFT_V_PER_H = 30e-6
SOFT_V = 40e-6
GRAVITY_U = "gravity_uncertainty_mps2 = 2e-6     # a standard uncertainty\n"
METER = ("nplc = 10", 'nplc = 10\nstandard = "meter"\ncrosstalk_ratio = 1e-9')
STANDARD = """
[standards.meter]
serial = "1"
certificate = "1"
due = 2999-12-31
kind = "limit"
uncertainty_v = 2e-5
"""


@pytest.fixture(scope="module")
def drifting(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A minute a dwell; x drifts by 30 µV an hour and repeats as sin 2α·cos R with 40 µV."""
    path = tmp_path_factory.mktemp("fit") / "obs.csv"
    write_observations(path, range(-90, 91, 15), range(-180, 180, 30), 5, noise_v=6e-6)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for index, row in enumerate(rows):
        pitch, roll = np.deg2rad(float(row["pitch_deg"])), np.deg2rad(float(row["roll_deg"]))
        row["time_s"] = str(60.0 * index)
        added = DRIFT_V_PER_H * index / 60.0 + SOFT_V * np.sin(2 * pitch) * np.cos(roll)
        row["sx_v"] = repr(float(row["sx_v"]) + float(added))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return path


def test_advice_names_the_term_and_the_drift(drifting: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = ("--axis", "x=sx_v", "--extended", "no")
    axis = call(capsys, "fit", drifting, *said, "--json").document["axes"]["x"]
    assert axis["advice"]["lack_of_fit"][0]["name"] == "sin 2α·cos R"
    assert axis["advice"]["lack_of_fit"][0]["amplitude_v"] == pytest.approx(SOFT_V, rel=0.1)
    text = call(capsys, "fit", drifting, *said).out
    assert "advice: The residuals repeat as sin 2α·cos R with 3.3″ (40 µV;" in text
    assert "advice: Offset drifts by +78 µV a replication" in text
    assert ", +30 µV an hour." in text


def test_a_time_term_takes_the_drift_with_its_interval(drifting: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "fit", drifting, "--axis", "x=sx_v", "--time-term", "linear", "--json").document
    drift = outcome["axes"]["x"]["parameters"]["offset_drift_v_per_h"]
    assert drift["value"] == pytest.approx(DRIFT_V_PER_H, abs=4.0 * drift["standard_uncertainty"])
    assert drift["standard_uncertainty"] < 1e-6
    assert any("never applied" in remark for remark in outcome["axes"]["x"]["remarks"])
    text = call(capsys, "fit", drifting, "--axis", "x=sx_v", "--time-term", "linear").out
    assert "offset drift" in text
    assert "V/h" in text
    assert "  remark: axis x: the offset holds at the reference time" in text
    assert "warning: axis x: the offset" not in text


def test_a_time_term_without_times_is_refused_with_the_column(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    untimed = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 2, noise_v=6e-6)
    done = call(capsys, "fit", untimed, "--axis", "x=sx_v", "--time-term", "linear")
    assert done.status == 2
    assert "no times were recorded" in done.err
    assert "column time_s" in done.err


def test_the_extended_model_is_told_whatever_the_verdict(drifting: Path, capsys: pytest.CaptureFixture[str]) -> None:
    axes = ("--axis", "x=sx_v", "--axis", "y=sy_v")
    text = call(capsys, "fit", drifting, *axes, "--extended", "test").out
    assert "terms of second order significant: F = " in text
    assert "terms of second order not significant: F = " in text
    assert "V/g²" in text


def test_a_rig_brings_its_meter_into_result_and_budget(
    drifting: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig_file(tmp_path, METER, more=STANDARD)
    found = call(capsys, "fit", drifting, "--axis", "y=sy_v", "--rig", tmp_path / "rig.toml", "--json").document
    axis = found["axes"]["y"]
    (zero,) = [line for line in axis["budget"]["lines"] if line["source"] == "multimeter zero"]
    assert (zero["type"], zero["stated"]) == ("B", "standards.meter: limit 20 µV")
    assert zero["standard_uncertainty"]["offset_v"] == pytest.approx(2e-5 / 3**0.5)
    assert axis["parameters"]["offset_v"]["standard_uncertainty"] > 2e-5 / 3**0.5
    text = call(capsys, "fit", drifting, "--axis", "y=sy_v", "--rig", tmp_path / "rig.toml").out
    assert "type B: multimeter zero (standards.meter: limit 20 µV)" in text


def rows_and_rig_at(folder: Path, latitude_deg: float) -> tuple[Path, Path]:
    """Sound rows of the polarity that the example's rig declares, and that rig moved to another latitude at 50 m.

    Its gravity is 9.79826 m/s².
    """
    truth = {axis: (offset, abs(sensitivity), *angles) for axis, (offset, sensitivity, *angles) in TRUTH.items()}
    where = (folder / "rows.csv", range(-60, 61, 30), range(-180, 180, 60), 4)
    rows = write_observations(*where, noise_v=6e-6, truth=truth)
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    assert "\nlatitude_deg = 37.09" in text
    rig = folder / "moved.toml"
    moved = text.replace("\nlatitude_deg = 37.09", f"\nlatitude_deg = {latitude_deg}\nheight_m = 50.0")
    moved = re.sub(r"(?m)^due = .*$", "due = 2099-12-31", moved)
    rig.write_text(moved, encoding="utf-8")
    return rows, rig


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_gravity_of_another_latitude_is_refused_by_file_and_line_and_no_set_is_written(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The International Gravity Formula of 1980 gives 9.81232 m/s² at 52° and 50 m: 0.0141 more than is stated."""
    rows, rig = rows_and_rig_at(tmp_path, 52.0)
    line = 1 + rig.read_text(encoding="utf-8").splitlines().index("gravity_mps2 = 9.79826")
    stored = tmp_path / "set.json"
    done = call(capsys, "fit", rows, *AXES, "--rig", rig, "--set", stored, "--sensor", "SN1047", *joint)
    assert (done.status, done.out) == (2, "")
    assert f"{rig}:{line}: rig.gravity_mps2: gravity is stated as 9.79826 m/s²" in done.err
    assert "0.0141 m/s² less, allowed 0.005 m/s²" in done.err
    assert not stored.exists()
    checked = call(capsys, "check", "--rig", rig, "--out", tmp_path)
    assert (checked.status, checked.err) == (2, done.err)
    with pytest.raises(DescriptionError, match=r"moved\.toml:\d+: rig\.gravity_mps2: .*0\.0141 m/s² less"):
        calrig.fit(rows, {"x": "sx_v"}, rig=rig)


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_doubtful_gravity_is_a_reservation_of_the_result_and_of_its_set(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At 39° and 50 m it is 9.80065 m/s², 0.0024 more; at the true latitude, 37.09°, nothing is said."""
    rows, rig = rows_and_rig_at(tmp_path, 39.0)
    stored = tmp_path / "set.json"
    line = ("fit", rows, *AXES, "--rig", rig, "--set", stored, "--sensor", "SN1047", *joint)
    document = call(capsys, *line, "--json").document
    assert document["verdict"] == "usable"
    for axis in document["axes"].values():
        (warning,) = [text for text in axis["warnings"] if "gravity is stated as 9.79826 m/s²" in text]
        assert "less, allowed 0.0015 m/s²" in warning
    assert warning in json.loads(stored.read_text(encoding="utf-8"))["warnings"]
    assert f"warning: {warning}" in call(capsys, *line).out
    if not joint:
        assert calrig.fit(rows, {"x": "sx_v"}, rig=rig).document["axes"]["x"]["warnings"] == [warning]
    near = call(capsys, "fit", rows, *AXES, "--rig", EXAMPLE_RIG, *joint, "--json").document
    assert "gravity" not in json.dumps(near["axes"]["x"]["warnings"])


def test_a_fit_without_a_table_says_so_wherever_its_numbers_go(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every place that has the uncertainties has the sentence, and with a rig file none has it."""
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    stored = tmp_path / "set.json"
    line = ("fit", rows, *AXES, "--set", stored, "--sensor", "SN1047")
    document = call(capsys, *line, "--gravity-mps2", "9.79826", "--json").document
    assert document["verdict"] == "usable"
    assert all(TABLE_NOT_COUNTED in " ".join(axis["warnings"]) for axis in document["axes"].values())
    entry = load_set(stored)
    grounds = Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))
    assert any(gap.startswith(TABLE_NOT_COUNTED) for gap in gaps_of(grounds))
    done = call(capsys, *line, "--gravity-mps2", "9.79826")
    assert done.out.count(f"warning: {TABLE_NOT_COUNTED}") == 3
    assert TABLE_NOT_COUNTED in calrig.fit(rows, {"x": "sx_v"}).document["axes"]["x"]["warnings"][0]
    assert TABLE_NOT_COUNTED not in json.dumps(call(capsys, *line, "--rig", rig, "--json").document)
    assert TABLE_NOT_COUNTED not in stored.read_text(encoding="utf-8")
    rig.write_text(
        re.sub(r"(?m)^uncertainty_arcsec = .*$", "uncertainty_arcsec = 0.0", rig.read_text(encoding="utf-8"))
    )
    zero = call(capsys, *line, "--rig", rig, "--json").document["axes"]["x"]["warnings"][0]
    assert zero == f"{TABLE_NOT_COUNTED}; the rig file states 0 of them ([axes.NAME] uncertainty_arcsec)"


@pytest.mark.parametrize("joint", [False, True])
def test_rows_without_a_temperature_say_that_no_other_is_in_the_uncertainty(
    joint: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Result, set and certificate have the sentence where the rows have no temperature, and none where they have."""
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    stored = tmp_path / "set.json"
    line = ("fit", rows, *AXES, *(("--joint",) if joint else ()), "--rig", rig, "--set", stored, "--sensor", "SN1047")
    assert NO_TEMPERATURE in json.dumps(call(capsys, *line, "--json").document["remarks" if joint else "axes"])
    assert any(text.startswith(NO_TEMPERATURE) for text in outside_uncertainty(load_set(stored).document))
    with rows.open(newline="", encoding="utf-8") as file:
        lines = [{**row, "temperature_degc": "21.5"} for row in csv.DictReader(file)]
    with rows.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(lines[0]))
        writer.writeheader()
        writer.writerows(lines)
    assert NO_TEMPERATURE not in json.dumps(call(capsys, *line, "--json").document)
    assert NO_TEMPERATURE not in stored.read_text(encoding="utf-8")


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_level_a_meter_and_a_gravity_that_nobody_declared_are_findings_of_a_fit_as_of_a_run(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    line = ("fit", rows, *AXES, "--rig", rig, "--sensor", "SN1047", *joint, "--json")
    rig.write_text(rig.read_text(encoding="utf-8").replace(GRAVITY_U, ""), encoding="utf-8")
    undeclared = [
        ("level-undeclared", NO_LEVEL),
        ("meter-undeclared", NO_METER),
        ("meter-undeclared", NO_CROSSTALK),
        ("gravity-undeclared", NO_GRAVITY),
    ]

    def found(axis: dict[str, object]) -> list[tuple[str, str]]:
        return [
            (entry["kind"], begins)
            for entry in axis["findings"]
            for begins in (NO_LEVEL, NO_METER, NO_CROSSTALK, NO_GRAVITY)
            if entry["text"].startswith(begins)
        ]

    for axis in call(capsys, *line).document["axes"].values():
        assert sorted(found(axis)) == sorted(undeclared)
    level = "[level]\nuncertainty_arcsec = 0.2\nbefore = { about_pitch_arcsec = 0.1, about_roll_arcsec = 0.1 }\n"
    stated = rig.read_text(encoding="utf-8").replace("[rig]\n", f"[rig]\n{GRAVITY_U}").replace(*METER)
    rig.write_text(stated + STANDARD + level, encoding="utf-8")
    assert not any(found(axis) for axis in call(capsys, *line).document["axes"].values())


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_sensor_that_the_rig_file_has_not_is_refused_with_those_that_it_has(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A set of it would state another sensor's rig as its own, or none of its meters."""
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    stored = tmp_path / "set.json"
    done = call(capsys, "fit", rows, *AXES, "--rig", rig, *joint, "--set", stored, "--sensor", "NOSUCH")
    assert (done.status, done.out) == (2, "")
    assert f"sensor 'NOSUCH': {rig} has no [sensors.NOSUCH] (allowed: SN1047)" in done.err
    assert not stored.exists()
    with pytest.raises(RequestError, match=r"moved\.toml has no \[sensors\.NOSUCH\] \(allowed: SN1047\)"):
        calrig.fit(rows, {"x": "sx_v"}, rig=rig, sensor="NOSUCH")


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_set_of_a_fit_names_the_standards_and_the_level_that_its_budget_counts(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A joint fit counts the level as the prior of the table's tilts: of 0.1″ read with ±0.2″, √(0.1² + 0.2²)/√3."""
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    level = "[level]\nuncertainty_arcsec = 0.2\nbefore = { about_pitch_arcsec = 0.1, about_roll_arcsec = 0.1 }\n"
    rig.write_text(rig.read_text(encoding="utf-8").replace(*METER) + STANDARD + level, encoding="utf-8")
    stored = tmp_path / "set.json"
    line = ("fit", rows, *AXES, "--rig", rig, *joint, "--set", stored, "--sensor", "SN1047", "--json")
    document = call(capsys, *line).document
    told = json.dumps(document)
    entry = load_set(stored)
    named = {str(standard["name"]) for standard in entry.provenance["standards"]}
    gaps = " ".join(gaps_of(Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))))
    assert "no standard is declared" not in gaps
    assert ("meter" in named, "meter" in gaps) == (("standards.meter: " in told), ("standards.meter: " not in told))
    assert "level of the base" not in gaps
    assert NO_LEVEL not in told
    if joint:
        priors = [document["nuisances"][name]["prior_arcsec"] for name in ("pitch zero", "base tilt")]
        assert priors == pytest.approx([(0.05 / 3) ** 0.5] * 2)
    else:
        assert "level of the base about" in told
    assert "standards.meter: " in told
    assert "table" in named


def test_a_joint_fit_whose_base_nobody_levelled_says_so_but_where_priors_declare_its_tilts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    line = ("fit", rows, *AXES, "--rig", rig, "--joint", "--json")
    assert any(text.startswith(NO_LEVEL) for text in call(capsys, *line).document["remarks"])
    priors = ("--prior", "pitch-zero=1", "--prior", "base-tilt=1")
    assert not any(text.startswith(NO_LEVEL) for text in call(capsys, *line, *priors).document["remarks"])


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_set_of_a_fit_carries_what_the_rig_file_declares_of_laboratory_job_and_acceptance(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    declared = """
[laboratory]
name = "Dimensional laboratory"
address = "1 Main Street"
capability_deg = 0.001
[job]
number = "26-0117"
customer = "Tunnel 2"
customer_contact = "2 Wind Road"
item = "three-axis package"
[acceptance]
pitch_limit_deg = 0.01
decision_rule = "simple"
"""
    rig.write_text(rig.read_text(encoding="utf-8") + declared, encoding="utf-8")
    stored = tmp_path / "set.json"
    assert call(capsys, "fit", rows, *AXES, "--rig", rig, *joint, "--set", stored, "--sensor", "SN1047").status == 0
    entry = load_set(stored)
    stated = {name: entry.provenance[name] for name in ("laboratory", "job", "acceptance")}
    assert stated == {
        name: tomllib.loads(declared)[name] | added
        for name, added in {"laboratory": {"accreditation": ""}, "job": {"remarks": ""}, "acceptance": {}}.items()
    }
    assert entry.document["sensor"]["model"] == "three-axis package"
    gaps = " ".join(gaps_of(Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))))
    assert "[laboratory]" not in gaps
    assert "[job]" not in gaps


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_a_standard_that_is_overdue_is_a_reservation_of_a_fit_in_the_words_of_a_run(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    rig.write_text(rig.read_text(encoding="utf-8").replace("2099-12-31", "2020-02-29"), encoding="utf-8")
    (refused,) = readiness(read_rig(rig), local_day(datetime.now(UTC))).contradictions
    assert refused.startswith("standards.table.due: 2020-02-29 is past (today is ")
    stored = tmp_path / "set.json"
    line = ("fit", rows, *AXES, "--rig", rig, *joint, "--set", stored, "--sensor", "SN1047", "--json")
    document = call(capsys, *line).document
    assert document["verdict"] == "usable"
    for axis in document["axes"].values():
        assert any(warning.startswith(refused) for warning in axis["warnings"])
    assert any(warning.startswith(refused) for warning in load_set(stored).document["warnings"])
    if not joint:
        assert any(refused in text for text in calrig.fit(rows, {"x": "sx_v"}, rig=rig).warnings)


@pytest.mark.parametrize(
    ("key", "limit", "verdict"),
    [
        ("largest_offset_shift_v", 4.9, "not usable"),
        ("largest_nonlinearity_v", 4.9, "not usable"),
        ("largest_sensitivity_shift", 0.99, "not usable"),
        ("largest_offset_shift_v", 0.1, "sound"),
        ("largest_offset_shift_v", 5e-5, "sound"),
    ],
)
def test_a_declared_limit_that_leaves_nothing_known_is_told_with_its_key_and_value(
    key: str, limit: float, verdict: str, tmp_path: Path
) -> None:
    """Of 2.5 V/g: ±0.1 V is 2.3° near level, ±50 µV four arc seconds; 4.9 V is more than the whole swing to 1 g."""
    rows, rig = rows_and_rig_at(tmp_path, 37.09)
    text = rig.read_text(encoding="utf-8")
    rig.write_text(text.replace("[sensors.SN1047]\n", f"[sensors.SN1047]\n{key} = {limit}\n"), encoding="utf-8")
    document = calrig.fit(rows, {"x": "sx_v", "y": "sy_v"}, rig=rig, sensor="SN1047").document
    assert document["verdict"] == verdict
    for axis in document["axes"].values():
        said = [text for text in axis["remarks"] if text.startswith("one declared figure is nearly all")]
        stated = f"({key}: limit {1e6 * limit:g} "
        assert bool(said) == (limit > 1e-3)
        assert all(stated in text for text in said)
        kinds = [finding["kind"] for finding in axis["findings"] if finding["significant"]]
        assert kinds == (["axis-undetermined"] if verdict == "not usable" else [])


def test_monte_carlo_stands_beside_the_budget(drifting: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "fit", drifting, "--axis", "y=sy_v", "--monte-carlo", 20_000, "--json").document
    check = outcome["axes"]["y"]["budget"]["monte_carlo"]
    assert (check["trials"], check["seed"]) == (20_000, 0)
    low, high = check["parameters"]["sensitivity_v_per_g"]["interval_95"]
    assert low < outcome["axes"]["y"]["parameters"]["sensitivity_v_per_g"]["value"] < high
    assert "Monte Carlo, 20000 trials" in call(capsys, "fit", drifting, "--axis", "y=sy_v", "--monte-carlo", 20_000).out


@pytest.mark.parametrize(("trials", "sentence"), [(5, "allowed 1000 to 10000000"), (-1, "got -1 trials")])
def test_a_number_of_trials_that_says_nothing_is_refused(
    trials: int, sentence: str, drifting: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = call(capsys, "fit", drifting, "--axis", "y=sy_v", f"--monte-carlo={trials}")
    assert done.status == 2
    assert sentence in done.err


def test_the_hessian_is_told_on_request(drifting: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "H_E is zero: the model is linear" in call(capsys, "fit", drifting, "--axis", "x=sx_v", "--hessian").out


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--joint", "--rig", "RIG", "--time-term", "linear"), "--joint: has no --time-term"),
        (("--joint", "--rig", "RIG", "--monte-carlo", "2000"), "not of linear and --joint"),
        (("--model", "linear", "--hessian"), "--hessian: a straight line has none"),
    ],
)
def test_what_a_fit_cannot_tell_is_refused_and_not_left_out(
    options: tuple[str, ...], sentence: str, drifting: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig_file(tmp_path)
    text = [str(tmp_path / "rig.toml") if option == "RIG" else option for option in options]
    done = call(capsys, "fit", drifting, "--axis", "x=sx_v", *text)
    assert done.status == 2
    assert sentence in done.err


def test_the_drift_of_a_straight_line_is_keyed_by_its_quantities(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chance = np.random.default_rng(0)
    lines = ["replication,point,reference_g,sx_v"]
    lines += [
        f"{r},{p},{level},{0.01 + 2.5 * level + 1e-5 * float(chance.standard_normal())!r}"
        for r in (1, 2, 3, 4)
        for p, level in enumerate((-1.0, 0.0, 1.0))
    ]
    path = tmp_path / "levels.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    axis = call(capsys, "fit", path, "--model", "linear", "--axis", "x=sx_v", "--json").document["axes"]["x"]
    assert set(axis["replication"]["drift"]) == {"gain", "offset"}


def _changed(source: Path, target: Path, change: Callable[[list[dict[str, str]]], None]) -> Path:
    with source.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    change(rows)
    with target.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return target


def test_a_clipped_axis_is_named_and_leaves_no_set(
    drifting: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def clip(rows: list[dict[str, str]]) -> None:
        for row in rows:
            row["sz_v"] = repr(min(float(row["sz_v"]), 2.3))

    data, stored = _changed(drifting, tmp_path / "clipped.csv", clip), tmp_path / "s.json"
    axes = call(capsys, "fit", data, *AXES, "--json").document["axes"]
    found = {axis: [one["kind"] for one in axes[axis]["findings"] if one["significant"]] for axis in axes}
    assert "output-clipped" in found["z"]
    assert "output-clipped" not in found["x"] + found["y"]
    asked = call(capsys, "fit", data, *AXES, "--set", stored, "--sensor", "S", "--gravity-mps2", "9.81")
    assert asked.status != 0
    assert "clipped: " in asked.err
    assert not stored.exists()


def test_copied_replications_are_refused(drifting: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def copy(rows: list[dict[str, str]]) -> None:
        first = {row["point"]: row for row in rows if row["replication"] == rows[0]["replication"]}
        for row in rows:
            if row["replication"] in ("3", "4"):
                row |= {name: first[row["point"]][name] for name in ("sx_v", "sy_v", "sz_v")}

    data = _changed(drifting, tmp_path / "copied.csv", copy)
    for words in ((), ("--joint", "--rig", EXAMPLE_RIG)):
        asked = call(capsys, "fit", data, *AXES, *words)
        assert asked.status != 0
        assert asked.out == ""
        assert "copied.csv: replications 3, 4 are copies of replication 1: " in asked.err
    with pytest.raises(ObservationsError, match="replications 3, 4 are copies of replication 1: "):
        calrig.fit(data, dict(zip("xyz", ("sx_v", "sy_v", "sz_v"), strict=True)))


def test_rows_copied_under_new_numbers_of_points_are_refused(
    drifting: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def copy(rows: list[dict[str, str]]) -> None:
        rows += [{**row, "point": str(1000 + int(row["point"]))} for row in rows if "point" in row]

    asked = call(capsys, "fit", _changed(drifting, tmp_path / "copied.csv", copy), *AXES)
    assert (asked.status, asked.out) == (2, "")
    assert "copied.csv: rows stand twice, under new numbers of points: " in asked.err
    assert "(points 1001 to " in asked.err
