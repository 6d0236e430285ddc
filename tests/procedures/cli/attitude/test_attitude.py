"""Laws of ``calrig attitude``: what was turned comes back, a wrong file is a sentence, a stream is answered at once."""

import csv
import io
import json
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from command import call
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, TABLE_4, accelerometer_v, gyro_v
from not_usable import set_not_usable, set_usable
from package_outputs import ATTITUDES, TRUTH, output_v, write_observations
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set, package_set, tp_set

from ams.exports.formats import export_set
from ams.inference.inference import inference
from ams.inputs.number_blocks import csv_blocks
from procedures.cli.attitude import rows as attitude_rows
from procedures.cli.attitude import stream as attitude_stream
from procedures.cli.attitude.package_file import package_of


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_angles_come_back_and_a_singular_one_is_an_empty_cell(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.csv"
    assert call(capsys, "attitude", stored, data, "--out", out, "--reading-sd-v", "1e-6").status == 0
    assert out.read_text().splitlines()[0] == "pitch_deg,pitch_sd_deg,roll_deg,roll_sd_deg,flag"
    rows = rows_of(out.read_text())
    for row, (pitch, roll) in zip(rows[:2], ATTITUDES[:2], strict=True):
        assert (float(row["pitch_deg"]), float(row["roll_deg"])) == pytest.approx((pitch, roll), abs=1e-7)
        assert row["flag"] == ""
    assert (rows[2]["roll_deg"], rows[2]["roll_sd_deg"], rows[2]["flag"]) == ("", "", "roll singular")


def test_a_set_that_is_not_usable_is_told_beside_its_answers_and_not_in_them(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = []
    for name, coefficients in (("beyond", set_not_usable()), ("plain", set_usable())):
        export_set(coefficients, "json", tmp_path / f"{name}.json")
        answers.append(call(capsys, "attitude", tmp_path / f"{name}.json", data))
    beyond, plain = answers
    ground = "not usable: the stated uncertainties do not hold what the data show (x: cubic)"
    assert beyond.err.splitlines()[0] == f"SN1047: verdict of the calibration: {ground}"
    assert beyond.err.count("not usable") == 1
    assert "verdict" not in plain.err
    assert (beyond.status, beyond.out) == (0, plain.out)


def test_a_set_of_fit_serves_at_once(tmp_path: Path, data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_observations(tmp_path / "obs.csv", range(-90, 91, 30), range(-180, 181, 60), 3, noise_v=2e-5)
    where = ("--set", tmp_path / "s.json", "--sensor", "SN1", "--gravity-mps2", "9.8")
    axes = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
    assert call(capsys, "fit", file, *axes, *where).status == 0
    assert call(capsys, "verify", tmp_path / "s.json").status == 0
    row = rows_of(call(capsys, "attitude", tmp_path / "s.json", data).out)[0]
    assert abs(float(row["pitch_deg"]) + 35.0) < 5 * float(row["pitch_sd_deg"]) < 0.01


def test_parquet_in_and_out_is_the_same_as_csv(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    pandas.read_csv(data).to_parquet(tmp_path / "data.parquet")
    assert call(capsys, "attitude", stored, tmp_path / "data.parquet", "--out", tmp_path / "out.parquet").status == 0
    found = pandas.read_parquet(tmp_path / "out.parquet")
    as_csv = rows_of(call(capsys, "attitude", stored, data).out)
    assert list(found["flag"]) == [row["flag"] for row in as_csv]
    np.testing.assert_allclose(found["pitch_deg"], [float(row["pitch_deg"]) for row in as_csv], rtol=1e-8)


def test_without_pyarrow_parquet_is_a_sentence(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ams.inputs.number_blocks.find_spec", lambda name: None)
    outcome = call(capsys, "attitude", stored, tmp_path / "data.parquet")
    assert outcome.status == 2
    assert "pyarrow is not installed" in outcome.err
    assert "use CSV" in outcome.err


MISTAKES = [
    ("a cell", lambda text: text.replace("\n", "\nx", 1), "line 2: column x_v: got"),
    ("a column", lambda text: text.replace("y_v", "w_v"), "column 'y_v' missing"),
    ("a word", lambda text: text + "n.a.,1,1\n", "line 5: column x_v: got 'n.a.'"),
    ("no rows", lambda text: text.splitlines()[0] + "\n", "a header and no rows"),
]


@pytest.mark.parametrize(("change", "sentence"), [m[1:] for m in MISTAKES], ids=[m[0] for m in MISTAKES])
def test_a_wrong_file_is_a_sentence_and_nothing_is_written(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], change: object, sentence: str
) -> None:
    data.write_text(change(data.read_text()))  # type: ignore[operator]
    outcome = call(capsys, "attitude", stored, data, "--out", tmp_path / "out.csv")
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err
    assert str(data) in outcome.err
    assert not (tmp_path / "out.csv").exists()


def test_missing_readings_of_a_file_are_flagged_and_counted_at_the_end(
    stored: Path, data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As a tunnel's recorder writes them; one is empty, two say so."""
    data.write_text(data.read_text() + "nan,1,1\n1,,1\n1,1,NaN\n")
    outcome = call(capsys, "attitude", stored, data)
    assert outcome.status == 0
    found = list(csv.DictReader(io.StringIO(outcome.out)))
    assert [row["pitch_deg"] == "" for row in found] == [False] * 3 + [True] * 3
    assert len({row["flag"] for row in found[3:]}) == 1
    assert f"4 of 6 rows are flagged: {found[3]['flag']} (3), roll singular (1)" in outcome.err  # the last is vertical


def test_nothing_is_said_of_flags_where_there_are_none(
    stored: Path, data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data.write_text("".join(data.read_text().splitlines(keepends=True)[:3]))  # without the vertical
    said, shifts, unseen = call(capsys, "attitude", stored, data).err.splitlines()
    assert "flag" not in said.removesuffix("and no flag")
    assert "rows are flagged" not in shifts
    assert "what 2 rows do not show" in unseen


def test_a_set_without_a_temperature_says_that_none_is_tested(
    stored: Path, data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Readings at 60 °C had no flag and no word."""
    header, *rows = data.read_text().splitlines()
    data.write_text("\n".join([f"{header},temperature_degc", *(f"{row},60.0" for row in rows[:2])]) + "\n")
    assert "TP1: no temperature was recorded in the calibration" in call(capsys, "attitude", stored, data).err


def test_a_damaged_set_is_refused(stored: Path, data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stored.write_bytes(stored.read_bytes().replace(b"2.5", b"2.6", 1))
    outcome = call(capsys, "attitude", stored, data)
    assert (outcome.status, outcome.out) == (2, "")
    assert str(stored) in outcome.err


def test_a_stream_is_answered_row_by_row_and_a_wrong_row_is_flagged(stored: Path, data: Path) -> None:
    header, first, second, _ = data.read_text().splitlines()
    process = subprocess.Popen(
        [sys.executable, "-m", "procedures.cli.main", "attitude", str(stored), "-"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
    )  # fmt: skip
    assert process.stdin is not None
    assert process.stdout is not None
    with process:
        process.stdin.write(header + "\n")
        assert process.stdout.readline() == "pitch_deg,pitch_sd_deg,roll_deg,roll_sd_deg,flag\n"
        for line, expected in ((first, -35.0), (second, 5.0)):
            process.stdin.write(line + "\n")
            answer = process.stdout.readline()  # before the next row is sent
            assert float(answer.split(",")[0]) == pytest.approx(expected, abs=1e-6)
        process.stdin.write("1.0,overload,0.2\n")
        assert process.stdout.readline() == ",,,,line 4: y_v no number\n"
        process.stdin.write("1.0,0.2\n")
        assert process.stdout.readline() == ",,,,line 5: 2 cells instead of 3\n"
        process.stdin.close()
        assert process.wait(timeout=30) == 0


def test_columns_of_cr_have_yaw(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for package in ("sting", "model"):
        export_set(package_set(package), "json", tmp_path / f"{package}.json")
    euler = (20.0, -15.0, -30.0)
    row = [accelerometer_v(a, TABLE_3_STING[a], euler, "sting") for a in "xyz"]
    row += [accelerometer_v(a, TABLE_3_MODEL[a], euler, "model") for a in "xyz"]
    names = [f"{package}_{axis}_v" for package in ("sting", "model") for axis in "xyz"]
    (tmp_path / "d.csv").write_text(",".join(names) + "\n" + ",".join(map(repr, row)) + "\n")
    sting = [part for axis in "xyz" for part in ("--axis", f"{axis}=sting_{axis}_v")]
    both = ("attitude", tmp_path / "sting.json", tmp_path / "d.csv", *sting, "--model-set", tmp_path / "model.json")
    found = rows_of(call(capsys, *both, "--reading-sd-v", "1e-6").out)[0]
    assert list(found) == [
        "pitch_deg", "pitch_sd_deg", "roll_deg", "roll_sd_deg", "yaw_deg", "yaw_sd_deg", "flag"
    ]  # fmt: skip
    assert [float(found[f"{name}_deg"]) for name in ("pitch", "yaw", "roll")] == pytest.approx(euler, abs=1e-6)


def test_a_cell_holds_nine_digits() -> None:
    assert next(attitude_rows.row_lines(["a", "b"], {"a": [12.3456789012], "b": [float("nan")]})) == "12.3456789,\n"


def test_fault_85_a_line_that_never_ends_is_told_and_the_next_one_answered(
    stored: Path, data: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Detected: a line longer than any row of a package.
    Response: no more of it is kept than a row may have; it is answered with a flag, and the next one is read.
    """
    header, *rows = data.read_text(encoding="utf-8").splitlines(keepends=True)
    endless = Counted(f"{header}{rows[0]}{'7' * 10_000_000}\n{rows[1]}".encode())
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(endless))
    tracemalloc.start()
    answers = rows_of(call(capsys, "attitude", stored, "-").out)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [answer["flag"] for answer in answers] == [
        "",
        f"line 3: longer than {attitude_stream.LONGEST_LINE} letters",
        "",
    ]
    assert peak < 8_000_000


class Counted(io.BytesIO):
    """A stream that brings no more than a pipe does at a time."""

    def read1(self, size: int = -1, /) -> bytes:
        return super().read1(min(size, 65_536))


@pytest.mark.parametrize("pieces", [1, 7, 400, 100_000])
def test_a_stream_says_what_the_file_says_however_it_arrives(
    stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], pieces: int
) -> None:
    rows = many_rows(300)
    rows[120] = "1.0,,3.0"
    path = tmp_path / "d.csv"
    path.write_text("\n".join(["x_v,y_v,z_v", *rows[:120], *rows[121:]]) + "\n")
    whole = call(capsys, "attitude", stored, path, "--reading-sd-v", "1e-5").out.splitlines()

    class Slow(io.BytesIO):
        def read1(self, size: int = -1, /) -> bytes:
            return super().read1(min(size, pieces))

    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(Slow("\n".join(["x_v,y_v,z_v", *rows]).encode())))
    found = call(capsys, "attitude", stored, "-", "--reading-sd-v", "1e-5").out.splitlines()
    assert found.pop(121) == ",,,,line 122: y_v no number"
    assert [cells(line) for line in found[1:]] == [cells(line) for line in whole[1:]]


@pytest.mark.parametrize(
    ("header", "words"),
    [("x_v,y_v,z_v,x_v", "column 'x_v' stands 2 times"), ("x_v;y_v;z_v", "separated by semicolons"), ("", "no header")],
)
def test_the_header_of_a_stream_is_refused_in_the_words_of_a_file(
    stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    header: str, words: str,
) -> None:  # fmt: skip
    """Of two columns of one name the last was taken, without a word."""
    text = f"{header}\n1.0,2.0,3.0,1.0\n" if header else ""
    path = tmp_path / "d.csv"
    path.write_text(text)
    of_file = call(capsys, "attitude", stored, path)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    of_stream = call(capsys, "attitude", stored, "-")
    assert (of_stream.status, of_stream.out) == (of_file.status, of_file.out)
    assert words in of_stream.err
    assert of_stream.err.replace("standard input", str(path)) == of_file.err


def test_a_stream_of_a_header_only_is_refused_as_a_file_is(
    stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "d.csv"
    path.write_text("x_v,y_v,z_v\n")
    of_file = call(capsys, "attitude", stored, path)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"x_v,y_v,z_v\n")))
    of_stream = call(capsys, "attitude", stored, "-")
    assert of_stream.status == of_file.status == 2
    assert "standard input: a header and no rows; nothing was computed" in of_stream.err


def test_cells_in_quotes_are_read_from_a_stream_as_from_a_file(
    stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = '"x_v","y_v","z_v"\n"0.1","0.2",-2.4\n'
    path = tmp_path / "d.csv"
    path.write_text(text)
    of_file = call(capsys, "attitude", stored, path)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    of_stream = call(capsys, "attitude", stored, "-")
    assert "no number" not in of_stream.out
    for found, expected in zip(of_stream.out.splitlines()[1:], of_file.out.splitlines()[1:], strict=True):
        assert cells(found) == cells(expected)


def cells(line: str) -> list[float | str]:
    """Return a line's numbers, however these are written, and its flag."""
    *numbers, flag = line.split(",")
    return [*(float(cell) if cell else "" for cell in numbers), flag]


def many_rows(count: int) -> list[str]:
    """Return lines of three outputs at different attitudes."""
    attitudes = zip(np.linspace(-80, 80, count).tolist(), np.linspace(-170, 170, count).tolist(), strict=True)
    return [",".join(repr(float(output_v(axis, TRUTH[axis], *attitude))) for axis in "xyz") for attitude in attitudes]


def test_every_way_of_writing_says_the_same(
    stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By pyarrow, by pandas, and a few rows by hand; JSON lines and Parquet beside CSV."""
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    path = tmp_path / "d.csv"
    lines = many_rows(120)
    lines[60] = ",".join(repr(output_v(axis, TRUTH[axis], 90.0, 10.0)) for axis in "xyz")
    lines[61] = "9.0,9.0,9.0"
    path.write_text("\n".join(["x_v,y_v,z_v", *lines]) + "\n")
    by_arrow = rows_of(call(capsys, "attitude", stored, path, "--reading-sd-v", "1e-5").out)
    assert by_arrow[60]["roll_deg"] == ""
    assert "redundancy: " in by_arrow[61]["flag"]
    for name in ("a.jsonl", "a.parquet"):
        assert call(capsys, "attitude", stored, path, "--reading-sd-v", "1e-5", "--out", tmp_path / name).status == 0
    documents = [json.loads(line) for line in (tmp_path / "a.jsonl").read_text().splitlines()]
    assert [document["flag"] for document in documents] == [row["flag"] for row in by_arrow]
    table = pandas.read_parquet(tmp_path / "a.parquet")
    assert documents[60]["roll_deg"] is None
    monkeypatch.setattr("procedures.cli.attitude.rows.find_spec", lambda name: None)
    by_pandas = rows_of(call(capsys, "attitude", stored, path, "--reading-sd-v", "1e-5").out)
    monkeypatch.setattr("procedures.cli.attitude.rows.FEW_ROWS", 1000)
    by_hand = rows_of(call(capsys, "attitude", stored, path, "--reading-sd-v", "1e-5").out)
    for name in ("pitch_deg", "pitch_sd_deg", "roll_deg", "roll_sd_deg"):
        expected = [float(row[name] or "nan") for row in by_hand]
        for rows in (by_arrow, by_pandas):
            assert [float(row[name] or "nan") for row in rows] == pytest.approx(expected, rel=1e-15, nan_ok=True)
            assert max(len(row[name].lstrip("-0.").partition("e")[0].replace(".", "")) for row in rows) <= 9
        in_lines = [np.nan if document[name] is None else document[name] for document in documents]
        np.testing.assert_allclose(in_lines, expected, rtol=1e-8)
        np.testing.assert_allclose(table[name], expected, rtol=1e-8)


def test_memory_does_not_grow_with_the_rows(stored: Path, tmp_path: Path) -> None:
    found = inference(package_of(stored, None, "--axis", ""))
    (tmp_path / "d.csv").write_text("x_v,y_v,z_v\n" + "\n".join(many_rows(500) * 400))
    tracemalloc.start()
    rows = sum(found.answer(block).codes.size for block in csv_blocks(tmp_path / "d.csv", found.needed))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert rows == 200_000
    assert peak < 30_000_000  # all rows in Python's numbers are 20 MB a column, as text 60 MB


def motion_file(path: Path, seconds: float = 3.0, rate_hz: float = 100.0) -> np.ndarray:
    """Write what gyros and accelerometers of one package read in a slow harmonic motion; return its angles, (n, 3)."""
    time_s = np.arange(round(seconds * rate_hz) + 1) / rate_hz
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    euler = 10.0 * np.sin(time_s[:, None] * omega)
    rates = 10.0 * omega * np.cos(time_s[:, None] * omega)
    moments = list(zip(euler.tolist(), rates.tolist(), strict=True))
    columns = {f"{a}_v": [gyro_v(a, truth, e, r) for e, r in moments] for a, truth in TABLE_4.items()}
    force = -Rotation.from_euler("YZX", euler, degrees=True).inv().apply([0.0, 0.0, 1.0])
    for axis, numbers in tp_set().axes.items():
        columns[f"accelerometer_{axis}_v"] = list(numbers.primary["offset_v"] + force @ numbers.direction_v_per_g)
    names = ["time_s", *columns]
    rows = zip(time_s.tolist(), *columns.values(), strict=True)
    path.write_text(",".join(names) + "\n" + "".join(",".join(repr(float(c)) for c in row) + "\n" for row in rows))
    return euler


@pytest.fixture
def gyros(tmp_path: Path) -> Path:
    export_set(gyro_set(), "json", tmp_path / "gyro.json")
    export_set(tp_set(), "json", tmp_path / "tp.json")
    return tmp_path / "gyro.json"


def angles_in(text: str) -> np.ndarray:
    return np.array([[float(row[f"{n}_deg"]) for n in ("pitch", "yaw", "roll")] for row in rows_of(text)])


def test_gyros_are_integrated_from_a_file_and_from_a_stream(
    gyros: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    euler = motion_file(tmp_path / "m.csv")
    outcome = call(capsys, "attitude", gyros, tmp_path / "m.csv", "--reading-sd-v", "1e-6")
    assert outcome.status == 0
    np.testing.assert_allclose(angles_in(outcome.out), euler, atol=1e-6)
    assert {row["flag"] for row in rows_of(outcome.out)} == {""}
    sds = [float(row["yaw_sd_deg"]) for row in rows_of(outcome.out)]
    assert sds[0] == 0.0
    assert 0.0 < sds[100] < sds[-1]
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO((tmp_path / "m.csv").read_bytes())))
    streamed = call(capsys, "attitude", gyros, "-", "--reading-sd-v", "1e-6", "--start-deg", "0", "0", "0")
    np.testing.assert_allclose(angles_in(streamed.out), euler, atol=1e-6)


def test_gyros_and_accelerometers_together(gyros: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    euler = motion_file(tmp_path / "m.csv", seconds=10.0)
    outcome = call(
        capsys, "attitude", gyros, tmp_path / "m.csv", "--accelerometers", tmp_path / "tp.json",
        "--reading-sd-v", "1e-4", "--out", tmp_path / "a.csv",
    )  # fmt: skip
    assert outcome.status == 0
    assert "mean normalised innovation of the force" in outcome.err
    np.testing.assert_allclose(angles_in((tmp_path / "a.csv").read_text())[200:], euler[200:], atol=0.05)


def test_a_rest_and_the_earth_are_taken_beside_accelerometers(
    gyros: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is taken for granted is said: of the zeros where nothing states them, of the Earth, of its heading."""
    motion_file(tmp_path / "m.csv", seconds=3.0)
    common = "attitude", gyros, tmp_path / "m.csv", "--accelerometers", tmp_path / "tp.json", "--reading-sd-v", "1e-4"
    plain = call(capsys, *common)
    assert "0.1 °/s (standard deviation) is taken; --zero-sd-dps states it, --rest-s measures the zeros" in plain.err
    assert "the Earth's turn, up to 15° an hour, is taken as a part of the zeros" in plain.err
    assert "zeros of the gyros at the end lie x " in plain.err
    stated = call(capsys, *common, "--zero-sd-dps", "0.001", "--latitude-deg", "60", "--heading-deg", "30")
    assert stated.status == 0
    assert "(standard deviation) is taken" not in stated.err
    assert "the heading, 30°, is taken as exact: each degree that it is off leaves 4e-05 °/s" in stated.err
    rested = call(capsys, *common, "--rest-s", "1", "--latitude-deg", "60", "--heading-deg", "30")
    assert rested.status == 0
    flags = [row["flag"] for row in rows_of(rested.out)]
    assert [flag.startswith("at rest: attitude of the start") for flag in flags] == [True] * 100 + [False] * 201
    assert "at rest the outputs lie" in rested.err
    assert "it did not rest" in rested.err


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--force-sd-g", "0.1"], "--force-sd-g: belongs to --accelerometers"),
        (["--intervals"], "--intervals: belongs to accelerometers, got gyros"),
        (["--model-set", "tp.json"], "--model-set: belongs to a sting package"),
        (["--rate-hz", "-1"], "sampling rate: got -1 Hz"),
        (["--start-deg", "0", "95", "0"], "got yaw 95°"),
        (["--accelerometers", "tp.json", "--rest-s", "2", "--zero-sd-dps", "1"], "give one of the two"),
        (["--accelerometers", "tp.json", "--zero-sd-dps", "-1"], "got zeros known within -1 °/s"),
        (["--accelerometers", "tp.json", "--heading-deg", "30"], "the Earth's turn needs both"),
        (["--zero-sd-dps", "0.1"], "--zero-sd-dps: belongs to --accelerometers"),
        (["--accelerometers", "tp.json", "--interpolation", "hold"], "--interpolation: the filter takes"),
        (["--accelerometers", "gyro.json"], "needed three accelerometers"),
    ],
)
def test_an_option_that_gyros_have_no_use_for_is_refused(
    gyros: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    motion_file(tmp_path / "m.csv", 0.1)
    full = [str(tmp_path / option) if option.endswith(".json") else option for option in options]
    outcome = call(capsys, "attitude", gyros, tmp_path / "m.csv", *full)
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err


def test_an_option_of_gyros_is_refused_for_accelerometers(
    stored: Path, data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "attitude", stored, data, "--rest-s", "1")
    assert outcome.status == 2
    assert "--rest-s: belongs to a set of gyros, got the model pitch-roll" in outcome.err
