"""Parts of the reports' tables at rest: what the text says of them, what a record of theirs shows, what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from motion_runs import motion_run

from procedures.errors import PlanError
from procedures.kinds.sensor_parts import PARTS, checked, forecast_of
from procedures.report.assemble import assemble_view
from procedures.report.overview import overview_rows

RATE_HZ = 100.0
DENSITY = 225e-6
SAMPLE_SD_G = DENSITY * math.sqrt(RATE_HZ / 2.0)
"""Of white noise of one-sided density d over the band up to half of the sampling rate."""
BUILT = {
    r"counts_per_unit = 1000+\.0": "counts_per_unit = 10000000.0",
    r"nominal_sensitivity_v_per_g = -0.5": "nominal_sensitivity_v_per_g = -0.25",
    r"sensitivity_v_per_g = [-\d.]+": "sensitivity_v_per_g = -0.25",
    r"sensitivity_v_per_dps = [-\d.]+": "sensitivity_v_per_dps = 0.00067",
    r"noise_v = [\d.]+": f"noise_v = {0.25 * SAMPLE_SD_G!r}",
}
PARTS_LINE = {r"(allowed_deg = 0.1)": '\\1\nparts = { ENC03J = "ENC-03J", ADXL105 = "ADXL105" }',
              r"duration_s = 1200.0": "duration_s = 160.0", r"use_s = 120.0": "use_s = 10.0"}  # fmt: skip


def test_two_minutes_of_samsung_s_drift_are_24_degrees_as_cr_says() -> None:
    """CR II-C: 'the maximum drift value indicates accumulation of 0.2 deg/s drift over a 2 min test … in 24 deg'."""
    assert PARTS["MG-L106C"].expected_deg(120.0) == pytest.approx(24.0)
    told = forecast_of("G1 (MG-L106C)", PARTS["MG-L106C"], 120.0, 0.1)
    assert told == "G1 (MG-L106C) by CR table 2: its drift alone makes 24° in 120 s, beyond the allowed ±0.1°"
    assert PARTS["SCA3000"].expected_deg(120.0) is None


def test_noise_of_the_density_of_the_table_is_off_by_what_the_table_lets_expect() -> None:
    """Means over the use, zeroed over as long before: simulated, twice their standard deviation."""
    chance, use = np.random.default_rng(1), 12.0
    means = (SAMPLE_SD_G * chance.normal(size=(4000, 2, int(use * RATE_HZ)))).mean(axis=2)
    simulated = 2.0 * np.rad2deg(np.std(means[:, 1] - means[:, 0]))
    assert PARTS["ADXL105"].expected_deg(use) == pytest.approx(simulated, rel=0.05)
    walk = SAMPLE_SD_G / math.sqrt(RATE_HZ)
    assert checked(PARTS["ADXL105"], walk, 0.0, 1.0) == ("white noise", "225 µg/√Hz", "230 µg/√Hz", "within the table")
    assert checked(PARTS["ADXL105"], 3.0 * walk, 0.0, 1.0)[3] == "3 times the table"
    assert checked(PARTS["SCA3000"], walk, 0.0, 1.0) == ()


def test_a_rest_is_held_against_the_tables_and_volts_become_degrees(tmp_path: Path) -> None:
    solved = motion_run(tmp_path, "rate-table", "../servo-mechanism/drift", PARTS_LINE, BUILT).solved()
    for axis in "xyz":
        told = solved.sensors["ADXL105"].static[axis]
        assert told.part == "ADXL105 (CR table 1)"
        assert float(told.beside_table[2].split()[0]) == pytest.approx(225.0, rel=0.1)
        gyro = solved.sensors["ENC03J"].static[axis]
        at_use = 0.25 * SAMPLE_SD_G / math.sqrt(RATE_HZ * 10.0) / 0.00067
        assert gyro.drift_deg == pytest.approx(2.0 * math.sqrt(2.0) * at_use * 10.0, rel=0.6)  # few means of 10 s
        assert gyro.beside_table[0] == "drift over the use"
    assert not solved.failures


@pytest.mark.thorough
def test_without_the_part_volts_of_a_gyro_have_no_verdict(tmp_path: Path) -> None:
    shorter = {pattern: new for pattern, new in PARTS_LINE.items() if "parts" not in new}
    solved = motion_run(tmp_path, "rate-table", "../servo-mechanism/drift", shorter, BUILT).solved()
    assert {one.drift_deg for one in solved.sensors["ENC03J"].static.values()} == {None}


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ('{ ENC03J = "ENC-3J" }', "ENC03J: got part 'ENC-3J'; allowed are ADXL105, "),
        ('{ G1 = "ENC-03J" }', "no sensor G1; allowed are ENC03J, ADXL105"),
        ('{ ENC03J = "ADXL105" }', "ENC03J: ADXL105 measures acceleration, the sensor rate; name another part"),
    ],
)
def test_a_part_that_is_none_is_a_sentence(parts: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"procedure\.toml:\d+: static\.parts: ") as refused:
        motion_run(tmp_path, "rate-table", "../servo-mechanism/drift", {r"(use_s = 120.0)": f"\\1\nparts = {parts}"})
    assert sentence in str(refused.value)


def test_the_overview_of_a_rest_says_what_the_run_s_verdict_says(tmp_path: Path) -> None:
    """It said of every sensor of a rest that it is not usable, beneath a verdict that all are."""
    run = motion_run(tmp_path, "servo-mechanism", "drift", {r"duration_s = 1200.0": "duration_s = 480.0"})
    solved = run.solved()
    words = {row.sensor: row.verdict for row in overview_rows(assemble_view(solved.record, solved.sensors))}
    assert words == {"SCA3000": "sound", "ITG3200": "usable", "MicroMag3": "usable"}
