"""Laws of ``calrig fit``: known parameters come back, and a wrong file is a sentence."""

import math
from pathlib import Path

import pytest
from command import call
from package_outputs import TRUTH, write_observations

from ams.exports.formats import load_set
from procedures.cli.results.coefficients_text import replication_line

NAMES = ("offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg")
AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")


@pytest.fixture
def noise_free(tmp_path: Path) -> Path:
    return write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 3)


def test_noise_free_parameters_are_recovered(noise_free: Path, capsys: pytest.CaptureFixture[str]) -> None:
    axes = call(capsys, "fit", noise_free, "--model", "pitch-roll", *AXES, "--json").document["axes"]
    for axis, truth in TRUTH.items():
        for name, value in zip(NAMES, truth, strict=True):
            assert math.isclose(axes[axis]["parameters"][name]["value"], value, rel_tol=1e-10, abs_tol=1e-10)


def test_the_document_has_the_form_others_rely_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    noisy = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 4, noise_v=6e-6)
    x = call(capsys, "fit", noisy, *AXES, "--json").document["axes"]["x"]
    terms = tuple(f"q_{pair}_v_per_g2" for pair in ("xx", "xy", "xz", "yy", "yz"))
    assert tuple(x["parameters"]) == (*NAMES, *terms, "k3_v_per_g3", "offset_traceless_v")
    assert set(x["parameters"]["offset_v"]) == {"value", "standard_uncertainty", "tp_standard_uncertainty"}
    assert [len(row) for row in x["covariance"]] == [11] * 11
    assert x["degrees_of_freedom"] == 4 * 49 - 10
    assert set(x["effective_degrees_of_freedom"]) == set(x["parameters"])
    assert set(x["sensitive_axis_v_per_g"]) == {"x", "y", "z"}
    assert (x["replication"]["n"], x["replication"]["points"]) == (4, 49)
    assert set(x["replication"]["lack_of_fit"]) >= {"t", "f_95"}
    assert set(x["replication"]["drift"]) == {"offset", "sensitivity", "coning", "azimuth"}
    assert set(x["replication"]["tp"]) == {"sigma_bias_v", "sigma_prec_v", "t_bias", "f_bias_95", "drift"}
    (warning,) = x["warnings"]
    assert warning.startswith("the table's own index errors are not in these uncertainties; a rig file (--rig")
    for name in NAMES:
        index = NAMES.index(name)
        assert x["covariance"][index][index] == pytest.approx(x["parameters"][name]["standard_uncertainty"] ** 2)


def test_a_lack_of_fit_that_what_is_known_explains_is_not_called_none() -> None:
    """T is against precision alone, and 387 times it is plain; p is against what is known of the table too."""
    test = {"t": 387.0, "f_95": 1.6}
    replication = {"n": 4, "points": 40, "lack_of_fit": test, "drift": {}}
    found = {"test": "lack of fit", "significant": False, "p_value": 1.0}
    assert "lack of fit no larger than what is known explains (T 387 against precision alone, p 1)" in replication_line(
        replication, [found]
    )
    by_chance = replication_line({**replication, "lack_of_fit": {"t": 1.7, "f_95": 1.6}}, [{**found, "p_value": 0.04}])
    assert "lack of fit not significant (T 1.7, p 0.04)" in by_chance
    assert "lack of fit significant (T 387, p 0)" in replication_line(
        replication, [{**found, "significant": True, "p_value": 0.0}]
    )


def test_a_person_reads_the_verdict_with_its_ground_as_the_set_states_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noisy = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 4, noise_v=6e-6)
    stated = "\nverdict of the calibration: "
    text = call(capsys, "fit", noisy, *AXES).out
    without_times = "; not tested for a drift inside the replications, of which no times are given"
    assert text.endswith(f"{stated}usable: the warnings must be read first{without_times}\n")
    assert "lack of fit not significant (T " in text
    assert "limit" not in text, "no single limit is held against a test that is one of many"
    head, *rows = noisy.read_text().splitlines()
    column = head.split(",").index("sx_v")
    cells = [row.split(",") for row in rows]
    for row in cells[110:]:
        row[column] = repr(float(row[column]) + 60e-6)
    stepped = tmp_path / "stepped.csv"
    stepped.write_text("\n".join([head, *map(",".join, cells)]) + "\n")
    where = ("--set", tmp_path / "s.json", "--sensor", "SN1", "--gravity-mps2", "9.8")
    text = call(capsys, "fit", stepped, *AXES, *where).out
    verdict = text[text.index(stated) + len(stated) :].strip()
    assert verdict == "not usable: the stated uncertainties do not hold what the data show (x: sensor-change)"
    assert load_set(tmp_path / "s.json").verdict == "not usable"


def test_one_replication_has_no_replication_analysis(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    single = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 1, noise_v=6e-6)
    assert call(capsys, "fit", single, "--axis", "x=sx_v", "--json").document["axes"]["x"]["replication"] is None


def test_a_replication_with_missing_points_is_used_with_a_warning(
    noise_free: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = noise_free.read_text().splitlines()
    noise_free.write_text("\n".join(line for line in lines if not line.startswith(("2,7,", "2,8,"))) + "\n")
    x = call(capsys, "fit", noise_free, "--axis", "x=sx_v", "--json").document["axes"]["x"]
    assert any("replication 2 lacks 2 of 49 points" in warning for warning in x["warnings"])
    assert math.isclose(x["parameters"]["azimuth_deg"]["value"], 35.0, rel_tol=1e-9)


MISTAKES = [
    ("NaN", lambda text: text.replace("2,7,-90,180", "2,7,nan,180"), "line 57"),
    ("repeated row", lambda text: text + text.splitlines()[-1] + "\n", "stands on line"),
    ("no such column", lambda text: text.replace("sx_v", "vx_v"), "sx_v"),
    ("roll at one value", lambda text: _without_roll(text), "roll"),
    ("fewer points than parameters", lambda text: "\n".join(text.splitlines()[:4]) + "\n", "point"),
    ("empty", lambda _: "", "empty"),
]


@pytest.mark.parametrize(("change", "sentence"), [m[1:] for m in MISTAKES], ids=[m[0] for m in MISTAKES])
def test_a_wrong_file_is_a_sentence(
    noise_free: Path, capsys: pytest.CaptureFixture[str], change: object, sentence: str
) -> None:
    before = noise_free.read_text()
    noise_free.write_text(change(before))  # type: ignore[operator]
    assert noise_free.read_text() != before
    outcome = call(capsys, "fit", noise_free, "--axis", "x=sx_v", "--json")
    assert outcome.status == 2
    assert outcome.out == ""
    assert sentence in outcome.err
    assert str(noise_free) in outcome.err
    assert "Traceback" not in outcome.err


def test_a_missing_file_is_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "fit", tmp_path / "nowhere.csv", "--axis", "x=sx_v")
    assert (outcome.status, outcome.out) == (2, "")
    assert "nowhere.csv" in outcome.err


@pytest.mark.parametrize("pair", ["x", "w=sx_v", "x="])
def test_an_axis_that_is_none_is_a_sentence(noise_free: Path, capsys: pytest.CaptureFixture[str], pair: str) -> None:
    outcome = call(capsys, "fit", noise_free, "--axis", pair)
    assert outcome.status == 2
    assert f"--axis {pair}" in outcome.err


def _without_roll(text: str) -> str:
    header, *rows = text.splitlines()
    return "\n".join([header, *(row for row in rows if row.split(",")[3] == "0")]) + "\n"
