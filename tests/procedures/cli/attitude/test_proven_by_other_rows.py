"""Rows that agree are flagged where others prove an axis wrong: in a file all of them, in a stream from then on.

The readings are made here: three axes, a fault of one of them, 10 µV of noise, any attitude within ±60°.
"""

import csv
import io
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from command import call
from package_outputs import TRUTH, output_v

ROWS = 600
SD_V = 1e-5
LATER = "redundancy: y proven wrong by other rows"


def _readings(faulty: slice, offset_v: float, seed: int) -> np.ndarray:
    """Return (ROWS, 3) outputs; within some rows y reads an offset of its own."""
    chance = np.random.default_rng(seed)
    pitch, roll = chance.uniform(-60.0, 60.0, ROWS), chance.uniform(-180.0, 180.0, ROWS)
    outputs = np.stack([np.array([output_v(axis, TRUTH[axis], p, r) for p, r in zip(pitch, roll, strict=True)])
                        for axis in "xyz"], axis=1)  # fmt: skip
    outputs += SD_V * chance.standard_normal(outputs.shape)
    outputs[faulty, 1] += offset_v
    return outputs


def _written(path: Path, outputs: np.ndarray) -> Path:
    np.savetxt(path, outputs, delimiter=",", header="x_v,y_v,z_v", comments="", fmt="%.9g")
    return path


def _flags(text: str) -> list[str]:
    return [row["flag"] for row in csv.DictReader(io.StringIO(text))]


@pytest.mark.parametrize("faulty", [slice(0, ROWS), slice(350, ROWS), slice(200, 420)])
def test_every_row_of_a_file_over_which_an_axis_is_wrong_is_flagged(
    faulty: slice, stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rows near level in y agree, whatever its offset: their roll is wrong all the same."""
    data = _written(tmp_path / "data.csv", _readings(faulty, 5e-4, seed=3))
    found = call(capsys, "attitude", stored, data, "--reading-sd-v", "1e-5")
    assert found.status == 0
    flags = _flags(found.out)
    within = flags[faulty]
    assert all(within)
    assert 0 < within.count(LATER) < 0.2 * len(within)
    outside = flags[: faulty.start] + flags[faulty.stop :]
    assert sum(bool(flag) for flag in outside) <= 0.02 * ROWS
    assert f"{LATER} ({flags.count(LATER)})" in found.err
    told = re.search(r"y is the faulty axis: an offset of \+(0\.\d+) ", found.err)
    assert told is not None
    assert abs(float(told[1]) - 0.5) < 0.01


def test_a_good_package_is_flagged_for_nothing_that_other_rows_say(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = _written(tmp_path / "data.csv", _readings(slice(0, 0), 0.0, seed=4))
    found = call(capsys, "attitude", stored, data, "--reading-sd-v", "1e-5")
    assert not any("other rows" in flag for flag in _flags(found.out))


def test_all_outputs_wrong_alike_flag_every_row(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A common gain of 2e-5 shows in some rows alone, and is in all of them."""
    outputs = _readings(slice(0, 0), 0.0, seed=5) * (1.0 + 2e-5)
    found = call(capsys, "attitude", stored, _written(tmp_path / "data.csv", outputs), "--reading-sd-v", "1e-5")
    flags = _flags(found.out)
    assert all(flags)
    assert "redundancy: outputs in doubt by other rows" in flags
    assert "all outputs are wrong alike" in found.err


def test_a_stream_flags_from_the_proof_on_and_says_which_rows_went_before(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    text = _written(tmp_path / "data.csv", _readings(slice(0, ROWS), 5e-4, seed=3)).read_bytes()

    class TenRows(io.BytesIO):
        """Rows that arrive ten at a time."""

        def read1(self, size: int | None = -1, /) -> bytes:
            return b"".join(self.readline() for _ in range(10))

    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(TenRows(text)))
    found = call(capsys, "attitude", stored, "-", "--reading-sd-v", "1e-5")
    flags = _flags(found.out)
    assert all(flags[40:])
    first = 1 + next(row for row, flag in enumerate(flags) if LATER in flag or "suspect y" in flag)
    assert f"rows 1 to {first - 1} were answered before that was proven" in found.err


def test_an_output_that_hangs_has_no_angles_and_is_named(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outputs = _readings(slice(0, 0), 0.0, seed=6)
    # Readings of a package at rest, as those that steps and noise are seen in: attitudes of this file jump.
    outputs[:100] = outputs[0] + SD_V * np.random.default_rng(7).standard_normal((100, 3))
    outputs[200:400, 1] = outputs[200, 1]
    found = call(capsys, "attitude", stored, _written(tmp_path / "data.csv", outputs), "--reading-sd-v", "1e-5")
    rows = list(csv.DictReader(io.StringIO(found.out)))
    assert found.status == 0
    assert all(row["pitch_deg"] == "" and "output frozen" in row["flag"] for row in rows[201:400])
    assert not any("frozen" in row["flag"] for row in rows[:201] + rows[400:])
    assert "y_v repeats one number in 199 rows" in found.err
