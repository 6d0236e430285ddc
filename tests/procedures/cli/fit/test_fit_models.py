"""Laws of ``calrig fit`` with CR's and SR's models: published parameters come back, a wrong request is a sentence."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import call
from cr_outputs import (
    TABLE_3_MODEL,
    TABLE_3_STING,
    TABLE_4,
    table_3_profile,
    table_4_profile,
    write_gyros,
    write_package,
    write_rows,
    write_second_step,
)
from package_outputs import TRUTH, output_v, write_observations

from ams.exports.formats import export_set, load_set
from ams.sets.applicability import check_applicability
from ams.sets.stated_findings import significant_findings

AXES = ("--axis", "x=x_v", "--axis", "y=y_v", "--axis", "z=z_v")
SPREAD = [(p, y, r) for p in (-40.0, 5.0, 30.0) for y in (-20.0, 0.0, 25.0) for r in (-60.0, 0.0, 45.0)]


def four_digits(parameters: dict, *names: str) -> list[str]:
    return [f"{parameters[name]['value']:.4f}" for name in names]


@pytest.mark.parametrize(("package", "table"), [("sting", TABLE_3_STING), ("model", TABLE_3_MODEL)])
def test_table_3_of_cr_is_recovered_to_every_printed_digit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], package: str, table: dict
) -> None:
    file = write_package(tmp_path / "obs.csv", package, table, table_3_profile())
    document = call(capsys, "fit", file, "--model", "pitch-yaw-roll", "--package", package, *AXES, "--json").document
    assert document["convention"] == "CR"
    assert document["verdict"] == "usable"  # nobody stated how far the indices may be wrong
    for axis, specified in table.items():
        found = document["axes"][axis]["parameters"]
        assert list(found) == ["offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg"]
        printed = four_digits(found, "offset_v", "sensitivity_v_per_g", "azimuth_deg", "coning_deg")
        assert printed == [f"{value:.4f}" for value in specified]


def test_an_output_of_a_sting_that_is_reversed_is_a_finding_of_document_and_set(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    offset, sensitivity, *angles = TABLE_3_STING["y"]
    reversed_y = {**TABLE_3_STING, "y": (offset, -sensitivity, *angles)}
    file = write_package(tmp_path / "obs.csv", "sting", reversed_y, table_3_profile())
    where = ("--set", tmp_path / "sting.json", "--sensor", "ST", "--gravity-mps2", "9.8", "--json")
    document = call(capsys, "fit", file, "--model", "pitch-yaw-roll", "--package", "sting", *AXES, *where).document
    (finding,) = (entry for entry in document["axes"]["y"]["findings"] if entry["kind"] == "axis-contradicted")
    assert finding["fits_with"] == "yaw of the opposite sign, or with output y of the opposite polarity"
    assert finding["text"] in document["axes"]["y"]["warnings"]
    names = [entry.name for entry in significant_findings(load_set(tmp_path / "sting.json"))]
    assert "y.axis-contradicted" in names
    assert not any(entry["kind"] == "axis-contradicted" for entry in document["axes"]["x"]["findings"])


def test_table_4_of_cr_is_recovered_to_every_printed_digit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_gyros(tmp_path / "gyros.csv", *table_4_profile())
    document = call(capsys, "fit", file, "--model", "gyro", *AXES, "--json").document
    for axis, specified in TABLE_4.items():
        found = document["axes"][axis]["parameters"]
        terms = ["k2_v_per_dps2", "k3_v_per_dps3"]
        assert list(found) == ["offset_v", "sensitivity_v_per_dps", "coning_deg", "azimuth_deg", *terms]
        printed = four_digits(found, "offset_v", "sensitivity_v_per_dps", "azimuth_deg", "coning_deg")
        assert printed == [f"{value:.4f}" for value in specified]
        assert document["axes"][axis]["sensitive_axis_v_per_dps"][axis] == pytest.approx(specified[1], rel=1e-4)


def test_replicated_packages_of_cr_have_the_whole_analysis(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_package(tmp_path / "obs.csv", "model", TABLE_3_MODEL, SPREAD, replications=5, noise_v=2e-5)
    y = call(capsys, "fit", file, "--model", "pitch-yaw-roll", "--package", "model", *AXES, "--json").document["axes"][
        "y"
    ]
    assert (y["replication"]["n"], y["replication"]["points"]) == (5, len(SPREAD))
    assert set(y["replication"]["drift"]) == {"offset", "sensitivity", "coning", "azimuth"}
    found = y["parameters"]["sensitivity_v_per_g"]
    assert abs(found["value"] - 0.49) < 5 * found["standard_uncertainty"] < 2e-4
    assert y["standard_error_v"] == pytest.approx(2e-5, rel=0.2)


def test_gyros_at_constant_rates_of_a_turning_table_have_the_whole_analysis(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one_at_a_time = [np.eye(3)[axis] * rate for axis in range(3) for rate in (-90.0, -30.0, 30.0, 90.0)]
    rates = np.array([np.zeros(3), *one_at_a_time])
    angles = np.zeros((13, 3))
    angles[9:, 2] = (10.0, 80.0, 200.0, -150.0)  # a rolling axis is read wherever it is
    file = write_gyros(tmp_path / "gyros.csv", angles, rates, replications=4, noise_v=1e-3)
    x = call(capsys, "fit", file, "--model", "gyro", *AXES, "--json").document["axes"]["x"]
    found = x["parameters"]["sensitivity_v_per_dps"]
    assert abs(found["value"] - 1.25) < 5 * found["standard_uncertainty"] < 1e-3
    assert set(x["replication"]["drift"]) == {"offset", "sensitivity", "coning", "azimuth"}


def linear_rows(levels: tuple[float, ...], replications: int, noise: float) -> list[list[object]]:
    chance = np.random.default_rng(3)
    return [
        [r, p, level, 1333.0 * (level - 0.02) / 1.0032 + noise * chance.normal()]
        for r in range(1, replications + 1)
        for p, level in enumerate(levels, start=1)
    ]


def test_two_levels_give_the_two_point_solution(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # SR: real = 1.0032·(counts / 1333) + 0.02 g; axis up and axis down.
    file = write_rows(tmp_path / "l.csv", ["reference_g", "ax_counts"], linear_rows((1.0, -1.0), 1, 0.0))
    x = call(capsys, "fit", file, "--model", "linear", "--axis", "x=ax_counts", "--json").document["axes"]["x"]
    assert x["parameters"]["gain_g_per_counts"]["value"] == pytest.approx(1.0032 / 1333, rel=1e-12)
    assert x["parameters"]["offset_g"]["value"] == pytest.approx(0.02, rel=1e-10)
    assert x["parameters"]["offset_g"]["standard_uncertainty"] is None
    assert "two levels once" in x["warnings"][0]


def test_many_levels_have_intervals_residuals_and_replication_tests(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = linear_rows((-1.0, -0.5, 0.0, 0.5, 1.0), 6, 0.5)
    file = write_rows(tmp_path / "l.csv", ["reference_g", "ax_counts"], rows)
    x = call(capsys, "fit", file, "--model", "linear", "--axis", "x=ax_counts", "--json").document["axes"]["x"]
    gain = x["parameters"]["gain_g_per_counts"]
    assert gain["interval_95"][0] < 1.0032 / 1333 < gain["interval_95"][1]
    # straight from the definition: u(A)/A = σ / (S √Σ(level − mean)²), Σ = 6·2.5 g², with the residuals' own σ
    sigma = np.std(x["residuals_counts"], ddof=2)
    assert x["standard_error_counts"] == pytest.approx(sigma, rel=1e-9)
    assert gain["tp_standard_uncertainty"] / gain["value"] == pytest.approx(sigma / 1328.7 / np.sqrt(15.0), rel=1e-3)
    assert set(x["replication"]["drift"]) == {"gain", "offset"}


def test_every_axis_may_have_levels_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [[1, p, x, y, 2.0 * float(x or 0) + 1.0, 3.0 * float(y or 0) - 1.0]
            for p, (x, y) in enumerate([(1.0, ""), (-1.0, ""), ("", 1.0), ("", -1.0)])]  # fmt: skip
    file = write_rows(tmp_path / "l.csv", ["reference_x_g", "reference_y_g", "x_v", "y_v"], rows)
    axes = call(capsys, "fit", file, "--model", "linear", "--axis", "x=x_v", "--axis", "y=y_v", "--json").document[
        "axes"
    ]
    assert axes["x"]["parameters"]["gain_g_per_v"]["value"] == pytest.approx(0.5)
    assert axes["y"]["parameters"]["gain_g_per_v"]["value"] == pytest.approx(1 / 3)


def warm(tmp_path: Path, replications: int = 4) -> Path:
    """TP's truth, 2e-4 V/°C on the offset and −3e-4 /°C on the sensitivity about 20 °C, plateaus from both sides."""
    rows: list[list[object]] = []
    for replication, temperature in enumerate((15.0, 25.0, 24.0, 16.0)[:replications], start=1):
        for point, (p, r) in enumerate([(p, r) for p in range(-90, 91, 30) for r in range(-180, 181, 60)], start=1):
            values = [_warmed(axis, p, r, temperature - 20.0) for axis in TRUTH]
            rows.append([replication, point, p, r, temperature, *values])
    names = ["pitch_deg", "roll_deg", "temperature_degc", *(f"{axis}_v" for axis in TRUTH)]
    return write_rows(tmp_path / "warm.csv", names, rows)


def _warmed(axis: str, pitch: float, roll: float, rise: float) -> float:
    clean, offset = output_v(axis, TRUTH[axis], pitch, roll), TRUTH[axis][0]
    return offset + 2e-4 * rise + (clean - offset) * (1.0 - 3e-4 * rise)


def test_known_temperature_coefficients_are_applied_and_unknown_ones_estimated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = warm(tmp_path)
    known = [part for axis in "xyz" for part in ("--known-temperature", f"{axis}=2e-4,-3e-4")]
    reference = ("--reference-temperature-degc", "20")
    for how in (("apply", *known), ("estimate",)):
        axes = call(capsys, "fit", file, *AXES, "--temperature", *how, *reference, "--json").document["axes"]
        for axis, (offset, sensitivity, *_) in TRUTH.items():
            found = {name: entry["value"] for name, entry in axes[axis]["parameters"].items()}
            assert found["offset_v"] == pytest.approx(offset, abs=1e-9)
            assert found["sensitivity_v_per_g"] == pytest.approx(sensitivity, rel=1e-9)
            assert found["offset_tc_v_per_degc"] == pytest.approx(2e-4, rel=1e-6)
            assert found["sensitivity_tc_per_degc"] == pytest.approx(-3e-4, rel=1e-6)


@pytest.mark.parametrize(("uncertainties", "is_declared"), [("", False), (",1e-6,2e-6", True), (",0,2e-6", False)])
def test_coefficients_that_are_applied_without_an_uncertainty_count_as_exact_and_that_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], uncertainties: str, is_declared: bool
) -> None:
    known = [part for axis in "xyz" for part in ("--known-temperature", f"{axis}=2e-4,-3e-4{uncertainties}")]
    asked = ("fit", warm(tmp_path), *AXES, "--temperature", "apply", *known, "--reference-temperature-degc", "20")
    printed = call(capsys, *asked).out
    assert ("no uncertainty of the known temperature coefficients is declared" in printed) is not is_declared
    assert ("exact" in printed) is not is_declared
    found = call(capsys, *asked, "--json").document["axes"]["x"]
    said = [text for text in found["remarks"] if "known temperature coefficients" in text]
    assert bool(said) is not is_declared


def test_a_gyro_has_temperature_terms_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rates = [np.eye(3)[axis] * rate for axis in range(3) for rate in (-90.0, 90.0)] + [np.zeros(3)]
    rows = [
        [n, p, 0.0, 0.0, *rate, t, 0.01 + 1e-3 * (t - 20) + 0.02 * (1 - 1e-3 * (t - 20)) * rate[2]]
        for n, t in enumerate((15.0, 25.0, 24.0, 16.0), start=1)
        for p, rate in enumerate(rates, start=1)
    ]
    names = ["yaw_deg", "roll_deg", "pitch_rate_dps", "roll_rate_dps", "yaw_rate_dps", "temperature_degc", "g_v"]
    names[3:5] = ["yaw_rate_dps", "roll_rate_dps"]
    file = write_rows(tmp_path / "g.csv", names, rows)
    how = ("--temperature", "estimate", "--reference-temperature-degc", "20")
    x = call(capsys, "fit", file, "--model", "gyro", "--axis", "x=g_v", *how, "--json").document["axes"]["x"]
    found = {name: entry["value"] for name, entry in x["parameters"].items()}
    assert found["sensitivity_v_per_dps"] == pytest.approx(0.02, rel=1e-9)
    assert "g-sensitivity of the gyros was not measured" in " ".join(x["remarks"])
    assert found["sensitivity_tc_per_degc"] == pytest.approx(-1e-3, rel=1e-6)
    assert found["offset_tc_v_per_degc"] == pytest.approx(1e-3, rel=1e-6)


REQUESTS = [
    (("--model", "pitch-yaw-roll"), "--package is missing"),
    (("--package", "sting"), "belongs to --model pitch-yaw-roll"),
    (("--temperature", "apply", "--known-temperature", "x=1e-5"), "OFFSET_TC,SENSITIVITY_TC"),
    (("--known-temperature", "x=1e-5,1e-5"), "belongs to --temperature apply"),
    (("--temperature-order", "2"), "belongs to --temperature estimate"),
    (("--temperature", "apply"), "axis x: no coefficients given"),
    (("--model", "gyro"), "pitch_rate_dps"),
    (("--model", "linear"), "reference_x_<unit>"),
    (("--set", "s.json"), "--sensor is missing"),
    (("--set", "s.json", "--sensor", "S1"), "--gravity-mps2 is missing"),
    (("--set", "s.json", "--sensor", "S1"), "give it, or --rig RIG"),
    (("--set", "s.json", "--sensor", "S1", "--gravity-mps2", "1"), "9.7 to 9.9"),
    (("--largest-g-sensitivity-dps-per-g", "0.1"), "belongs to --model gyro, not to --model pitch-roll"),
    (
        ("--model", "gyro", "--largest-g-sensitivity-dps-per-g", "nan"),
        "got nan, allowed above 0 and below 10 °/s per g",
    ),
    (("--model", "gyro", "--largest-g-sensitivity-dps-per-g", "-1"), "got -1, allowed above 0"),
]


@pytest.mark.parametrize(("options", "sentence"), REQUESTS, ids=[" ".join(r[0]) for r in REQUESTS])
def test_a_wrong_request_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], sentence: str
) -> None:
    file = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 2)
    outcome = call(capsys, "fit", file, "--axis", "x=sx_v", *options, "--json")
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err
    assert "Traceback" not in outcome.err


def test_a_yaw_that_the_model_would_ignore_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_package(tmp_path / "obs.csv", "model", TABLE_3_MODEL, SPREAD)
    outcome = call(capsys, "fit", file, *AXES)
    assert outcome.status == 2
    assert "yaw_deg: got 25° in replication 1, point 7" in outcome.err
    assert "pitch-yaw-roll" in outcome.err


def test_a_motion_about_one_axis_only_is_refused_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rates = np.array([[rate, 0.0, 0.0] for rate in (-60.0, -20.0, 0.0, 20.0, 60.0, 80.0)])
    file = write_gyros(tmp_path / "g.csv", np.zeros((6, 3)), rates)
    outcome = call(capsys, "fit", file, "--model", "gyro", *AXES)
    assert outcome.status == 2
    assert "cannot determine k_x_v_per_dps and k_z_v_per_dps" in outcome.err
    assert "all three of its axes" in outcome.err


def test_a_point_whose_rate_changed_names_line_and_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rates = np.array([np.eye(3)[a] * r for a in range(3) for r in (-60.0, 60.0)])
    file = write_gyros(tmp_path / "g.csv", np.zeros((6, 3)), rates, replications=2)
    text = file.read_text().splitlines()
    text[8] = text[8].replace("60.0", "61.0", 1)
    file.write_text("\n".join(text) + "\n")
    outcome = call(capsys, "fit", file, "--model", "gyro", *AXES)
    assert outcome.status == 2
    assert "line 9: columns pitch_rate_dps" in outcome.err
    assert "line 3" in outcome.err


def test_rates_in_radians_draw_a_warning_that_names_the_columns(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rates = np.deg2rad([np.eye(3)[a] * r for a in range(3) for r in (-60.0, 45.0)])
    file = write_gyros(tmp_path / "g.csv", np.zeros((6, 3)), rates)
    x = call(capsys, "fit", file, "--model", "gyro", *AXES, "--json").document["axes"]["x"]
    assert any("columns pitch_rate_dps, yaw_rate_dps, roll_rate_dps" in warning for warning in x["warnings"])


def test_the_second_step_of_cr_needs_roll_and_the_stings_outputs_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_package(tmp_path / "sting.csv", "sting", TABLE_3_STING, table_3_profile())
    where = ("--set", tmp_path / "sting.json", "--sensor", "ST", "--gravity-mps2", "9.8")
    call(capsys, "fit", file, "--model", "pitch-yaw-roll", "--package", "sting", *AXES, *where)
    file = write_second_step(tmp_path / "model.csv")
    model = ("--model", "pitch-yaw-roll", "--package", "model", "--sting", tmp_path / "sting.json")
    document = call(capsys, "fit", file, *model, *AXES, "--json").document
    for axis, specified in TABLE_3_MODEL.items():
        found = document["axes"][axis]["parameters"]
        printed = four_digits(found, "offset_v", "sensitivity_v_per_g", "azimuth_deg", "coning_deg")
        assert printed == [f"{value:.4f}" for value in specified]
        assert (
            "gravity is that of the sting package: what its set leaves uncertain is in"
            in document["axes"][axis]["warnings"][0]
        )


def test_a_sting_belongs_to_a_model_package(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 2)
    outcome = call(capsys, "fit", file, "--axis", "x=sx_v", "--sting", tmp_path / "s.json")
    assert outcome.status == 2
    assert "belongs to --model pitch-yaw-roll --package model" in outcome.err


def test_a_rate_table_that_is_fast_is_in_the_sensitivity_of_a_gyro_where_its_rate_is_declared_and_told_where_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """0.1 % too fast: the sensitivity, 1.25 V/(°/s), comes out 0.1 % high."""
    rates = np.array([np.eye(3)[axis] * rate for rate in (-90.0, 30.0, -30.0, 90.0) for axis in range(3)])
    file = write_gyros(tmp_path / "g.csv", np.zeros((12, 3)), 1.001 * rates, replications=4, noise_v=1e-4)
    header, *rows = file.read_text().splitlines()
    columns = header.split(",")
    indices = [columns.index(name) for name in ("pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps")]
    stated = [row.split(",") for row in rows]
    for row in stated:
        for location in indices:
            row[location] = repr(float(row[location]) / 1.001)
    file.write_text("\n".join([header, *(",".join(row) for row in stated)]) + "\n")
    gyro = ("fit", file, "--model", "gyro", *AXES)

    silent = call(capsys, *gyro, "--json").document["axes"]["x"]["parameters"]["sensitivity_v_per_dps"]
    assert silent["value"] == pytest.approx(1.25 * 1.001, rel=1e-4)
    assert abs(silent["value"] - 1.25) > 10.0 * silent["standard_uncertainty"]
    assert "the rate table's own errors are not in these uncertainties" in call(capsys, *gyro).out

    declared = call(capsys, *gyro, "--rate-uncertainty-ppm", "1000", "--json").document["axes"]["x"]["parameters"]
    found = declared["sensitivity_v_per_dps"]
    assert found["standard_uncertainty"] == pytest.approx(1.25e-3, rel=0.01)
    assert abs(found["value"] - 1.25) < 2.0 * found["standard_uncertainty"]
    said = call(capsys, *gyro, "--rate-uncertainty-ppm", "1000").out
    assert "the rate table's own errors are not" not in said
    assert "Earth's rotation" in said


def test_a_limit_on_what_gravity_does_to_gyros_is_in_their_offsets_and_takes_the_remark_away(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A rectangle of two g, as upside down: nothing in the file says where the package stood while it turned."""
    rates = np.vstack([np.kron(np.eye(3), np.array([[-90.0], [-40.0], [40.0], [90.0]])), np.zeros((1, 3))])
    file = write_gyros(tmp_path / "g.csv", np.zeros((13, 3)), rates, replications=3, noise_v=1e-6)
    line = ("fit", file, "--model", "gyro", *AXES, "--json")
    silent, said = call(capsys, *line), call(capsys, *line, "--largest-g-sensitivity-dps-per-g", "0.01")
    for axis, (_, sensitivity, *_) in TABLE_4.items():
        bare, counted = (each.document["axes"][axis] for each in (silent, said))
        remarks = [" ".join(each["remarks"]).count("g-sensitivity") for each in (bare, counted)]
        assert remarks == [1, 0]
        u_v = counted["parameters"]["offset_v"]["standard_uncertainty"]
        assert u_v == pytest.approx(2.0 * 0.01 * sensitivity / 3.0**0.5, rel=1e-3)
        assert bare["parameters"]["offset_v"]["standard_uncertainty"] < 1e-3 * u_v
        (source,) = (entry for entry in counted["budget"]["lines"] if entry["source"] == "g-sensitivity")
        assert source["standard_uncertainty"]["offset_v"] == pytest.approx(u_v, rel=1e-3)


@pytest.mark.parametrize("stated", [(), ("--gravity-mps2", "9.81")], ids=["unstated", "stated"])
def test_a_set_of_gyros_needs_no_gravity(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], stated: tuple[str, ...]
) -> None:
    """It stands at standard gravity and says that none was stated; no certificate of it tells a gravity of the site."""
    angles, rates = table_4_profile()
    file, path = write_gyros(tmp_path / "gyros.csv", angles, rates), tmp_path / "g.json"
    asked = call(capsys, "fit", file, "--model", "gyro", *AXES, "--set", path, "--sensor", "G1", *stated)
    assert asked.status == 0, asked.err
    unit = json.loads(path.read_text(encoding="utf-8"))["acceleration_unit"]
    assert unit["value_mps2"] == (9.81 if stated else 9.80665)
    assert ("none was stated" in unit["source"]) == (not stated)
    coefficients = load_set(path)
    check_applicability(coefficients, None, 9.78)
    export_set(coefficients, "dcc", tmp_path / "g.xml")
    written = (tmp_path / "g.xml").read_text(encoding="utf-8")
    assert ("local acceleration of gravity" in written) == bool(stated)


@pytest.mark.parametrize(("unit", "status"), [("g", 2), ("dps", 0), ("ut", 0)])
def test_a_set_of_straight_lines_needs_gravity_where_they_are_per_g(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], unit: str, status: int
) -> None:
    rows = [
        [replication, point, level, 2.0 * level + 0.1 + 1e-3 * (replication * point % 3)]
        for replication in (1, 2, 3)
        for point, level in enumerate((-1.0, -0.5, 0.5, 1.0), start=1)
    ]
    file = write_rows(tmp_path / "lines.csv", [f"reference_{unit}", "s_v"], rows)
    line = ("fit", file, "--model", "linear", "--axis", "x=s_v", "--set", tmp_path / "l.json", "--sensor", "L1")
    asked = call(capsys, *line)
    assert asked.status == status, asked.err
    assert (tmp_path / "l.json").exists() == (status == 0)
    assert ("the levels are in g" in asked.err) == (status != 0)
    assert call(capsys, *line, "--gravity-mps2", "9.8").status == 0


def test_lines_of_several_axes_say_that_how_these_lie_is_not_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three axes 1° off their nominal directions are as good straight lines as three that are square."""
    rows = [
        [replication, point, level, *(gain * level + 1e-3 * (replication * point % 3) for gain in (2.0, -1.9))]
        for replication in (1, 2, 3)
        for point, level in enumerate((-1.0, -0.5, 0.5, 1.0), start=1)
    ]
    file = write_rows(tmp_path / "lines.csv", ["reference_dps", "a_v", "b_v"], rows)
    where = ("--set", tmp_path / "l.json", "--sensor", "L1")
    said = "not tested for how the sensitive axes lie to one another"
    assert said in call(capsys, "fit", file, "--model", "linear", "--axis", "x=a_v", "--axis", "y=b_v", *where).out
    assert said not in call(capsys, "fit", file, "--model", "linear", "--axis", "x=a_v", *where).out


def test_an_uncertainty_of_rates_belongs_to_gyros(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_rows(tmp_path / "l.csv", ["reference_g", "ax_counts"], linear_rows((1.0, 0.0, -1.0), 2, 0.5))
    line = ("fit", file, "--model", "linear", "--axis", "x=ax_counts")
    assert "belongs to --model gyro" in call(capsys, *line, "--rate-uncertainty-ppm", "100").err


def test_a_set_of_rolls_that_go_round_is_valid_all_round(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As a run's is: a grid of 30° up to 150° leaves no gap that is wider than its step."""
    attitudes = [(float(pitch), float(roll)) for pitch in range(-60, 61, 30) for roll in range(-180, 180, 30)]
    outputs = [[output_v(axis, TRUTH[axis], p, r) for axis in "xyz"] for p, r in attitudes]
    rows = [
        [replication, point, *attitude, *(value + 1e-5 * np.cos(7.0 * point * replication) for value in read)]
        for replication in (1, 2, 3)
        for point, (attitude, read) in enumerate(zip(attitudes, outputs, strict=True))
    ]
    file = write_rows(tmp_path / "round.csv", ["pitch_deg", "roll_deg", *(f"{axis}_v" for axis in "xyz")], rows)
    where = ("--set", tmp_path / "round.json", "--sensor", "R1", "--gravity-mps2", "9.8")
    assert call(capsys, "fit", file, "--model", "pitch-roll", *AXES, *where).status == 0
    assert json.loads((tmp_path / "round.json").read_text())["validity"]["roll_deg"] == [-180.0, 180.0]
