"""A scanner whose channels leak: declared it is in forecast, result, budget and set, else it is said."""

from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from example_files import EXAMPLE_RIG
from small_run import RIG, bench

from ams.observations import Observations
from procedures.check.check_report import check
from procedures.delivery.deliver import sets_of, solve_run
from procedures.kinds.read import read_procedure
from procedures.records.declared_gaps import crosstalk_remarks
from procedures.solution.crosstalk import CROSSTALK, leaking_channels, with_scanned_volts
from procedures.solution.type_b import shared_errors
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError

NPLC = "nplc = 1\n"
SINGLE = "channels = { x = { scanner = 1, range_v = 10.0 } }"


def rig_with(folder: Path, *changes: tuple[str, str]) -> RigDescription:
    text = RIG
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = folder / "rig.toml"
    path.write_text(text)
    return read_rig(path)


def declared(ratio: float) -> tuple[str, str]:
    return (NPLC, f"{NPLC}crosstalk_ratio = {ratio:g}\n")


def test_every_other_channel_of_the_scanner_leaks_by_a_part_of_its_own(tmp_path) -> None:
    rig = rig_with(tmp_path, declared(1e-5))
    sensor = rig.sensors["SN1"]
    assert leaking_channels(rig, sensor) == ("dmm.x", "dmm.y", "dmm.z")
    for errors in shared_errors(rig, sensor).values():
        (error,) = (error for error in errors if error.name == CROSSTALK)
        assert error.columns == (0, 1, 2)
        assert error.is_of_one_channel  # what y puts into x is not what x puts into y
        assert error.axes == ("x", "y", "z")
        assert error.standard_uncertainty == pytest.approx(1e-5 / sqrt(3.0))
        assert error.stated == "readouts.dmm: limit 1e-05 of the volts of each of 2 other channels"


def test_what_nobody_declared_is_said_and_what_has_no_scanner_is_not(tmp_path) -> None:
    rig = rig_with(tmp_path)
    (said,) = crosstalk_remarks(rig, rig.sensors["SN1"])
    assert said.fact.startswith("no crosstalk of the scanner is declared (dmm): ")
    assert "readouts.dmm.crosstalk_ratio" in said.what_to_do
    known = rig_with(tmp_path, declared(1e-5))
    assert crosstalk_remarks(known, known.sensors["SN1"]) == ()
    assert crosstalk_remarks(known, None) == ()


@pytest.mark.parametrize("value", ["-1e-5", "0.0", "0.02", "-100.0", "nan", "true", '"1e-5"'])
def test_what_is_no_ratio_is_refused(tmp_path, value: str) -> None:
    with pytest.raises(DescriptionError, match="crosstalk_ratio"):
        rig_with(tmp_path, (NPLC, f"{NPLC}crosstalk_ratio = {value}\n"))


def test_check_expects_it_and_the_run_states_it(tmp_path) -> None:
    """Leaks of y and z into x: by −100 dB their offsets and sensitivities, each a rectangle, far above the noise."""
    ratio = 1e-3
    made = bench(tmp_path, rig=(declared(ratio),))
    made.run(tmp_path / "run")
    sensor = solve_run(tmp_path / "run").sensors["SN1"]
    assert sensor.calibration is not None
    assert not any("crosstalk" in remark for remark in sensor.calibration.remarks)
    (line,) = (line for line in sensor.budgets["x"].lines if line.source == CROSSTALK)
    assert line.type == "B"
    of_offset = ratio / sqrt(3.0) * np.hypot(0.003, 0.008)
    assert line.contributions["offset_v"] == pytest.approx(of_offset, rel=0.2)
    across = sensor.calibration.axes["x"]
    k_y = across.primary_covariance[2, 2] ** 0.5
    assert k_y == pytest.approx(ratio / sqrt(3.0) * 2.48, rel=0.05)
    for expected in check(made.rig, read_procedure(tmp_path / "procedure.toml")).forecast.expected:
        stated = {item.name: item.interval_95 for item in sensor.calibration.axes[expected.axis].parameters}
        interval, half = stated["coning_deg"], expected.half_width_95["coning_deg"]
        assert interval is not None
        assert half == pytest.approx(0.5 * (interval[1] - interval[0]), rel=0.1)


def test_rows_of_a_file_have_what_is_declared_of_channels_that_it_lacks(tmp_path) -> None:
    """A supply has its nominal volts, a channel that nobody describes all of its range."""
    channels = "channels = { x = { scanner = 1, range_v = 10.0 }, "
    supply = "s = { scanner = 4, range_v = 10.0 }, free = { scanner = 5, range_v = 1.0 }, "
    chain = '[chain."dmm.x"]\nsupply_channel = "dmm.s"\nsupply_nominal_v = 5.0\n[environment.air]'
    rig = rig_with(tmp_path, declared(1e-5), (channels, channels + supply), ("[environment.air]", chain))
    chance = np.random.default_rng(3)
    pitch = np.tile(np.deg2rad([-60.0, -30.0, 0.0, 30.0, 60.0, 90.0, 10.0, -80.0]), 3)
    roll = np.tile(np.deg2rad([0.0, 90.0, 180.0, -90.0, 45.0, 0.0, 130.0, -20.0]), 3)
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    rows = Observations(
        replication=np.repeat([1, 2, 3], 8),
        point=np.tile(np.arange(8), 3),
        pitch_rad=pitch,
        roll_rad=roll,
        outputs={"x": 2.5 * force[0] + 1e-5 * chance.standard_normal(24)},
    )
    scanned_v = with_scanned_volts(rows, rig, rig.sensors["SN1"]).scanned_v
    assert scanned_v is not None
    places = {name: place for place, name in enumerate(leaking_channels(rig, rig.sensors["SN1"]))}
    np.testing.assert_allclose(scanned_v[:, places["dmm.y"]], 2.5 * force[1])
    np.testing.assert_array_equal(scanned_v[:, places["dmm.s"]], 5.0)
    np.testing.assert_array_equal(scanned_v[:, places["dmm.free"]], 1.0)
    assert with_scanned_volts(rows, rig, None) is rows


def test_a_rig_without_it_changes_nothing_of_the_rows(tmp_path) -> None:
    rig = read_rig(EXAMPLE_RIG)
    sensor = rig.sensors["SN1047"]
    rows = Observations(np.array([1]), np.array([1]), np.zeros(1), np.zeros(1), {"x": np.zeros(1)})
    if not leaking_channels(rig, sensor):
        assert with_scanned_volts(rows, rig, sensor) is rows


def test_a_set_says_what_read_the_outputs_and_which_volts_the_supply_had(tmp_path) -> None:
    """The twin's supply stands 2 mV above the middle of its band."""
    channels = "channels = { x = { scanner = 1, range_v = 10.0 }, "
    supply = "s = { scanner = 4, range_v = 10.0 }, "
    chain = '[chain."dmm.x"]\nsupply_channel = "dmm.s"\nsupply_band_v = [4.9, 5.1]\n[environment.air]'
    twin = '[twin.supplies]\n"dmm.s" = { error_v = 0.002 }\n[twin.truth.SN1]'
    changes = (declared(1e-5), (channels, channels + supply), ("[environment.air]", chain), ("[twin.truth.SN1]", twin))
    bench(tmp_path, rig=changes).run(tmp_path / "run")
    (made,) = sets_of(solve_run(tmp_path / "run")).values()
    readouts, supplies = made.provenance["readouts"], made.provenance["supplies"]
    assert isinstance(readouts, dict)
    assert isinstance(supplies, dict)
    told = dict(readouts["dmm"])
    assert "HP3458A" in told.pop("identity")
    assert told == {"driver": "hp3458a", "axes": ["x", "y", "z"], "scanned": True, "crosstalk_ratio": 1e-5}
    (channel,) = supplies
    assert channel == "dmm.s"
    assert list(supplies[channel].values()) == pytest.approx([5.002] * 3, abs=5e-4)
