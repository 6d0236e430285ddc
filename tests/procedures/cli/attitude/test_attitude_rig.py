"""Laws of ``calrig attitude --rig --stream``: a rig's own stream becomes angles, and nobody else is at it meanwhile."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from command import call
from line_sets import line_set
from solved_sets import gyro_set, tp_set

from ams.exports.formats import export_set
from ams.sets.coefficients import CoefficientSet
from procedures.cli.attitude.rig_stream import StreamRows
from rig.abilities.abilities import StreamBlock, StreamGap
from rig.lines.lock import acquire

RIG = Path(__file__).parents[4] / "examples" / "servo-mechanism" / "rig.toml"
TRUTH = {"x": (1.003200, 0.020660), "y": (1.027799, -0.065900), "z": (1.011900, -0.024300)}
"""A and B of the rig's twin: reading = (real - B) / A."""


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """Return a copy of the example, whose lock is this test's own."""
    path = tmp_path / "rig.toml"
    path.write_text(RIG.read_text())
    return path


def stored(folder: Path, found: CoefficientSet, name: str) -> Path:
    path = folder / name
    export_set(found, "json", path)
    return path


def accelerometers(folder: Path) -> Path:
    levels = np.tile([-1.0, -0.5, 0.5, 1.0], 4)
    return stored(folder, line_set(TRUTH, "g", "g", levels=levels, scatter=1e-3), "acc.json")


CHANNELS = [part for axis in "xyz" for part in ("--axis", f"{axis}=imu.a{axis}")]


def test_a_stream_of_the_rig_becomes_angles_and_nothing_moves(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The twin's board lies level; its noise is 2 mg, one sample a second."""
    outcome = call(
        capsys, "attitude", accelerometers(tmp_path), "--rig", rig, "--stream", "imu", "--for", 40, *CHANNELS
    )
    rows = list(csv.DictReader(io.StringIO(outcome.out)))
    assert (outcome.status, len(rows) >= 38) == (0, True)
    pitch = np.array([float(row["pitch_deg"]) for row in rows])
    assert abs(pitch.mean()) < 0.25  # coning of the twin's axes, 0.2°, which a line does not know
    assert pitch.std() == pytest.approx(np.rad2deg(0.002), rel=0.5)
    assert f"streams.imu: {len(rows)} samples, 0 missing" in outcome.err


def test_somebody_else_s_rig_is_not_read_and_its_owner_is_named(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with acquire([str(rig)], "run"):
        outcome = call(capsys, "attitude", accelerometers(tmp_path), "--rig", rig, "--stream", "imu", *CHANNELS)
    assert outcome.status != 0
    assert "(run)" in outcome.err
    assert "process" in outcome.err


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (["--stream", "none"], "has no such stream; nothing was opened; its streams are imu, ahrs"),
        (["--stream", "imu"], "whose set this is, has no channels on the stream imu"),
        (["--stream", "imu", "--axis", "x=imu.gx"], "comes in °/s, the set takes g"),
        (["--stream", "imu", "--axis", "x=imu.q"], "has no such channel"),
        (["--stream", "imu", "--for", "0", *CHANNELS], "got a time that is not above 0 s"),
    ],
)
def test_what_the_rig_does_not_tell_is_a_sentence(
    rig: Path, tmp_path: Path, given: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "attitude", accelerometers(tmp_path), "--rig", rig, *given)
    assert (outcome.status, sentence in outcome.err) == (2, True), outcome.err


def test_data_or_a_rig_is_given_and_not_both(rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = accelerometers(tmp_path)
    assert "give one of the two" in call(capsys, "attitude", own).err
    assert "give one of the two" in call(capsys, "attitude", own, "-", "--rig", rig, "--stream", "imu").err
    assert "belong together" in call(capsys, "attitude", own, "--rig", rig).err
    assert "--for: belongs to --stream" in call(capsys, "attitude", own, "-", "--for", 3).err


class Board:
    """Four samples a second, two channels."""

    name, rate_hz, channels = "imu", 4.0, ("imu.a", "imu.b")


def block(samples: int, gaps: list[StreamGap], times: list[float] | None = None) -> StreamBlock:
    own = np.full(samples, np.nan) if times is None else np.array(times)
    values = {name: np.zeros(samples) for name in Board.channels}
    return StreamBlock("imu", 0, values, own, 0.0, tuple(gaps), 0)


def test_missing_samples_show_in_the_times() -> None:
    rows = StreamRows(Board())  # type: ignore[arg-type]
    first = rows.readings([block(3, [StreamGap(1, 2, "")]), block(2, [StreamGap(2, None, "")])])
    assert (first["time_s"] * 4.0).tolist() == [0.0, 3.0, 4.0, 5.0, 6.0]
    again = rows.readings([block(3, [StreamGap(2, 0, "twice")])])
    assert (again["time_s"] * 4.0).tolist() == [8.0, 9.0, 9.0]
    assert (rows.samples, rows.lost) == (8, 3)
    assert rows.readings([block(2, [], [7.0, 7.25])])["time_s"].tolist() == [7.0, 7.25]


def test_a_device_that_does_not_keep_the_stated_rate_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    rows = StreamRows(Board())  # type: ignore[arg-type]
    rows.readings([block(60, [], (np.arange(60) / 4.1).tolist())])
    assert "sends 4.1 samples a second by its own time, 4 by the rig file" in capsys.readouterr().err


def test_gyros_take_butcher_s_method_and_a_field_by_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At rest: gyros at their zeros, gravity down, and a field that says where x points."""
    gyros, force = gyro_set(), tp_set()
    field = line_set(dict.fromkeys("xyz", (1.0 / 30.0, 0.0)))
    at_rest = {f"{axis}_v": numbers.primary["offset_v"] for axis, numbers in gyros.axes.items()}
    feels = {
        f"accelerometer_{axis}_v": numbers.primary["offset_v"] - numbers.direction_v_per_g[2]
        for axis, numbers in force.axes.items()
    }
    yaw = np.deg2rad(20.0)
    sensed = np.array([21.0 * np.cos(yaw), -21.0 * np.sin(yaw), 43.0])
    counts = {f"magnetometer_{axis}_counts": 30.0 * own for axis, own in zip("xyz", sensed.tolist(), strict=True)}
    row = at_rest | feels | counts
    data = tmp_path / "rest.csv"
    data.write_text(",".join(row) + "\n" + (",".join(map(repr, map(float, row.values()))) + "\n") * 60)
    gyro_file, force_file = stored(tmp_path, gyros, "g.json"), stored(tmp_path, force, "a.json")
    field_file = stored(tmp_path, field, "m.json")
    both = ["--accelerometers", force_file, "--magnetometers", field_file]
    common = ["attitude", gyro_file, data, "--rate-hz", 20, "--reading-sd-v", 0.01]
    outcome = call(capsys, *common, *both, "--field-ut", 21, 0, 43)
    last = list(csv.DictReader(io.StringIO(outcome.out)))[-1]
    assert float(last["yaw_deg"]) == pytest.approx(20.0, abs=1e-3)
    assert "innovation of the field" in outcome.err
    assert "the field where they are used is missing" in call(capsys, *common, *both).err
    assert "belongs to --magnetometers" in call(capsys, *common, *both[:2], "--field-ut", 21, 0, 43).err
    by_butcher = call(capsys, *common, "--method", "butcher")
    assert (by_butcher.status, len(by_butcher.out.splitlines())) == (0, 61)
    assert "the filter carries the quaternion" in call(capsys, *common, *both[:2], "--method", "butcher").err
