"""Rates and times that contradict each other, and times not in seconds: refused wherever rows come from."""

import io
import socket
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from command import call
from solved_sets import gyro_set, tp_set

from ams.exports.formats import export_set

ROWS = 600


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with both sets and ``m.csv``: gyros and accelerometers that turn about y, rows at 100 Hz."""
    export_set(gyro_set(), "json", tmp_path / "gyro.json")
    export_set(tp_set(), "json", tmp_path / "tp.json")
    write_motion(tmp_path / "m.csv", 1.0)
    return tmp_path


def write_motion(path: Path, seconds_are: float) -> None:
    """Write a swing of 10° about y, its times in a unit of which ``seconds_are`` make a second."""
    time_s = np.arange(ROWS) / 100.0
    pitch = np.deg2rad(10.0) * np.sin(2 * np.pi * 0.125 * time_s)
    rates = np.zeros((ROWS, 3))
    rates[:, 1] = 10.0 * 2 * np.pi * 0.125 * np.cos(2 * np.pi * 0.125 * time_s)
    force = np.stack([np.sin(pitch), 0.0 * pitch, -np.cos(pitch)], axis=-1)
    columns = {"time_s": time_s * seconds_are}
    columns |= {f"{a}_v": n.primary["offset_v"] + rates @ n.direction for a, n in gyro_set().axes.items()}
    for axis, numbers in tp_set().axes.items():
        columns[f"accelerometer_{axis}_v"] = numbers.primary["offset_v"] + force @ numbers.direction_v_per_g
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    path.write_text(",".join(columns) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))


GYROS = ("gyro.json", "--reading-sd-v", "1e-5")
WAYS = {
    "gyros": GYROS,
    "filter": (*GYROS, "--accelerometers", "tp.json"),
    "averages": ("tp.json", "--average-s", "0.5", *(f"--axis={a}=accelerometer_{a}_v" for a in "xyz")),
    "low pass": ("tp.json", "--low-pass-hz", "5", *(f"--axis={a}=accelerometer_{a}_v" for a in "xyz")),
}


def given(folder: Path, way: str) -> list[object]:
    return [folder / text if text.endswith(".json") else text for text in WAYS[way]]


@pytest.mark.parametrize("way", WAYS)
def test_a_rate_that_the_file_contradicts_is_refused_and_nothing_is_written(
    folder: Path, capsys: pytest.CaptureFixture[str], way: str
) -> None:
    first, *options = given(folder, way)
    outcome = call(capsys, "attitude", first, folder / "m.csv", *options, "--rate-hz", "98", "--out", folder / "a.csv")
    assert outcome.status != 0
    assert "98 Hz is stated (--rate-hz), time_s tells 100 Hz" in outcome.err
    assert not (folder / "a.csv").exists()
    same = call(capsys, "attitude", first, folder / "m.csv", *options, "--rate-hz", "100")
    without = call(capsys, "attitude", first, folder / "m.csv", *options)
    assert same.status == without.status == 0
    np.testing.assert_allclose(numbers_of(same.out), numbers_of(without.out), atol=1e-6)


def numbers_of(text: str) -> np.ndarray:
    """Return every number of the answer but those of the last column, NaN where there is none."""
    return np.array([[float(cell or "nan") for cell in row.split(",")[:-1]] for row in text.splitlines()[1:]])


def test_standard_input_and_a_socket_are_refused_as_soon_as_it_shows(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    first, *options = given(folder, "gyros")
    rows = (folder / "m.csv").read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(rows)))
    piped = call(capsys, "attitude", first, "-", *options, "--rate-hz", "98")
    assert piped.status != 0
    assert "98 Hz is stated" in piped.err
    with socket.create_server(("127.0.0.1", 0)) as server:

        def send() -> None:
            connection, _ = server.accept()
            with connection:
                connection.sendall(rows)

        sending = threading.Thread(target=send)
        sending.start()
        address = f"socket://127.0.0.1:{server.getsockname()[1]}"
        connected = call(capsys, "attitude", first, address, *options, "--rate-hz", "98")
        sending.join()
    assert connected.status != 0
    assert "98 Hz is stated" in connected.err


@pytest.mark.parametrize("way", ["gyros", "filter"])
def test_times_in_milliseconds_are_not_integrated(folder: Path, capsys: pytest.CaptureFixture[str], way: str) -> None:
    write_motion(folder / "ms.csv", 1000.0)
    first, *options = given(folder, way)
    refused = call(capsys, "attitude", first, folder / "ms.csv", *options)
    assert refused.status != 0
    assert "rows lie 10 apart (median), read as seconds; allowed is 1 s" in refused.err
    assert "give time_s in seconds" in refused.err


def test_accelerometers_at_rest_are_averaged_over_rows_ten_seconds_apart(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_motion(folder / "slow.csv", 1000.0)
    _, *options = given(folder, "averages")
    options[1] = "100"
    assert call(capsys, "attitude", folder / "tp.json", folder / "slow.csv", *options).status == 0
