"""Laws of ``calrig attitude``'s options: what is done to samples before, where rows come from, where answers go."""

import csv
import io
import json
import socket
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from command import call
from package_outputs import ATTITUDES, TRUTH, output_v
from rich.console import Console
from threadpoolctl import threadpool_info, threadpool_limits

from ams.arrays import FloatArray
from ams.inference.inference import Inference, inference
from ams.inference.rows.angle_stream import Answer
from procedures.cli.attitude import lines as attitude_lines
from procedures.cli.attitude import rows as attitude_rows
from procedures.cli.attitude import stream as attitude_stream
from procedures.cli.attitude.package_file import package_of
from procedures.cli.attitude.plot import PlottedRows
from procedures.cli.attitude.view import ViewedRows
from rig.clock import VirtualClock


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_outputs_are_filtered_and_averaged_before_they_become_angles(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half a volt of 20 Hz on the x axis is twelve degrees; behind the filter it is none."""
    time_s = np.arange(400) / 100.0
    outputs = {axis: output_v(axis, TRUTH[axis], 5.0, 60.0) for axis in "xyz"}
    shaken = outputs["x"] + 0.5 * np.sin(2 * np.pi * 20.0 * time_s)
    rows = [f"{t:.2f},{x!r},{outputs['y']!r},{outputs['z']!r}\n" for t, x in zip(time_s, shaken.tolist(), strict=True)]
    path = tmp_path / "shaken.csv"
    path.write_text("time_s,x_v,y_v,z_v\n" + "".join(rows))
    filtered = rows_of(call(capsys, "attitude", stored, path, "--low-pass-hz", "1.0").out)
    assert len(filtered) == 400
    assert float(filtered[250]["pitch_deg"]) == pytest.approx(5.0, abs=0.01)
    assert filtered[0]["flag"].endswith("filter not settled")
    told = call(capsys, "attitude", stored, path, "--average-s", "0.5")
    averaged = rows_of(told.out)
    assert "standard deviations count the noise of one reading" in told.err
    stated = call(capsys, "attitude", stored, path, "--average-s", "0.5", "--reading-sd-v", "1e-6")
    assert "the noise of one reading" not in stated.err
    assert [row["time_s"] for row in averaged][:2] == ["0.245", "0.745"]
    assert float(averaged[3]["pitch_deg"]) == pytest.approx(5.0, abs=1e-6)  # ten periods a window
    refused = call(capsys, "attitude", stored, path, "--low-pass-order", "3")
    assert (refused.status, "belongs to --low-pass-hz" in refused.err) == (2, True)
    assert "--rate-hz: belongs to a set of gyros" in call(capsys, "attitude", stored, path, "--rate-hz", "50").err


def test_rows_come_by_datagram_and_answers_leave_by_datagram(stored: Path) -> None:
    rows = [[output_v(axis, TRUTH[axis], p, r) for axis in "xyz"] for p, r in ATTITUDES[:2]]
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as mouth,
    ):
        ear.bind(("127.0.0.1", 0))
        listening.bind(("127.0.0.1", 0))
        ear.settimeout(5.0)
        for datagram in ("x_v,y_v,z_v", *(",".join(map(repr, row)) for row in rows), ""):
            mouth.sendto(datagram.encode(), listening.getsockname())
        found = inference(package_of(stored, None, "--axis", ""))
        with attitude_lines.opened_target(f"udp://127.0.0.1:{ear.getsockname()[1]}") as target:
            attitude_stream.answer_stream(
                found,
                lambda columns: (attitude_rows.JsonRows(target, columns), target),
                attitude_lines.Datagrams(listening),  # type: ignore[arg-type]
            )
        messages: list[dict] = []
        while len(messages) < 2:
            messages += [json.loads(line) for line in ear.recv(65_536).decode().splitlines()]
    assert [row["pitch_deg"] for row in messages] == pytest.approx([pitch for pitch, _ in ATTITUDES[:2]], abs=1e-7)


@pytest.mark.parametrize("address", ["udp://127.0.0.1", "udp://:5005", "socket://host:port"])
def test_an_address_that_is_none_is_a_sentence(stored: Path, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "attitude", stored, address)
    assert (outcome.status, "is no address: allowed are socket://HOST:PORT and udp://HOST:PORT" in outcome.err) == (
        2,
        True,
    )


def test_the_view_shows_the_newest_row_with_rate_and_loss(stored: Path) -> None:
    """Two hundred rows in one second of a clock that jumps, the last of them known, one of them no number."""
    clock, shown = VirtualClock(datetime(2026, 3, 1, tzinfo=UTC)), io.StringIO()
    found = inference(package_of(stored, None, "--axis", ""))
    rows = [[output_v(axis, TRUTH[axis], -35.0, -20.0) for axis in "xyz"] for _ in range(200)]
    rows[10][1] = float("nan")
    viewed = ViewedRows("TP1", Console(file=shown, width=80, force_terminal=False), clock, None)
    for index in range(0, 200, 50):
        clock.sleep(0.25)
        block = np.array(rows[index : index + 50]).T
        viewed.write(attitude_rows.Rows.of(found.answer(dict(zip(("x_v", "y_v", "z_v"), block, strict=True)))))
    viewed.close()
    text = shown.getvalue()
    assert "-35.0000°" in text
    assert "-20.0000°" in text
    assert "200 rows   200 /s   1 flagged   1 without an attitude" in text
    assert "no flag" in text


def test_a_view_of_a_file_is_a_sentence(stored: Path, data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "attitude", stored, data, "--view")
    assert (outcome.status, "--view: shows rows as they arrive" in outcome.err) == (2, True)


def test_an_alignment_is_solved_stored_and_used(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The model's pitch is two degrees more than the package's at no roll, by the known attitudes of three rows."""
    known = tmp_path / "known.csv"
    rows = [[output_v(axis, TRUTH[axis], p, r) for axis in "xyz"] for p, r in ((-30.0, 0.0), (0.0, 0.0), (40.0, 0.0))]
    rows.append([output_v(axis, TRUTH[axis], 0.0, 180.0) for axis in "xyz"])
    truths = ((-28.0, 0.0), (2.0, 0.0), (42.0, 0.0), (2.0, 180.0))  # turned about y: upside down as much the other way
    truths = (*truths[:3], (-2.0, 180.0))
    known.write_text(
        "x_v,y_v,z_v,pitch_deg,roll_deg\n"
        + "".join(",".join(map(repr, (*row, *true))) + "\n" for row, true in zip(rows, truths, strict=True))
    )
    out = tmp_path / "alignment.json"
    outcome = call(capsys, "attitude", stored, known, "--solve-alignment", out)
    assert (outcome.status, "alignment: " in outcome.err) == (0, True)
    assert "the known attitudes were taken as exact but for their scatter" in outcome.err
    level = tmp_path / "level.csv"
    level.write_text("x_v,y_v,z_v\n" + ",".join(repr(output_v(a, TRUTH[a], 10.0, 0.0)) for a in "xyz") + "\n")
    used = call(capsys, "attitude", stored, level, "--alignment", out)
    (row,) = rows_of(used.out)
    assert float(row["pitch_deg"]) == pytest.approx(12.0, abs=1e-6)
    assert "the known attitudes were taken as exact" in used.err
    outcome = call(capsys, "attitude", stored, known, "--solve-alignment", out, "--known-sd-deg", "0.03")
    assert (outcome.status, "in it 0.03° that the known attitudes have in common" in outcome.err) == (0, True)
    used = call(capsys, "attitude", stored, level, "--alignment", out, "--reading-sd-v", "1e-9")
    assert float(rows_of(used.out)[0]["pitch_sd_deg"]) == pytest.approx(0.03, rel=0.01), "about the pitch axis"
    assert "taken as exact" not in used.err


REFUSED_BESIDE = [
    (("--intervals",), "does not go with --intervals; nothing was stored"),
    (("--view", "--plot", "a.svg"), "does not go with --view, --plot; nothing was stored"),
    (("--known-sd-deg", "-0.1"), "--known-sd-deg: got -0.1, allowed 0 to 1"),
]


@pytest.mark.parametrize(("options", "sentence"), REFUSED_BESIDE, ids=[sentence for _, sentence in REFUSED_BESIDE])
def test_what_would_change_nothing_beside_an_alignment_is_refused(
    stored: Path,
    data: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    options: tuple[str, ...],
    sentence: str,
) -> None:
    out = tmp_path / "alignment.json"
    outcome = call(capsys, "attitude", stored, data, "--solve-alignment", out, *options)
    assert (outcome.status, sentence in outcome.err, out.exists()) == (2, True, False)
    outcome = call(capsys, "attitude", stored, data, "--known-sd-deg", "0.1")
    assert (outcome.status, "belongs to --solve-alignment" in outcome.err) == (2, True)


def test_a_picture_of_many_rows_holds_so_many_that_it_shows(stored: Path, tmp_path: Path) -> None:
    found = inference(package_of(stored, None, "--axis", ""))
    pitch = np.linspace(-80.0, 80.0, 50_000)
    block = np.array([output_v(axis, TRUTH[axis], 0.0, 0.0) for axis in "xyz"])[:, None].repeat(pitch.size, axis=1)
    rows = attitude_rows.Rows.of(found.answer(dict(zip(("x_v", "y_v", "z_v"), block, strict=True))))
    plot, written = tmp_path / "a.svg", io.BytesIO()
    writer = PlottedRows("TP1", plot, attitude_rows.CsvRows(written, found.answers))
    for _ in range(3):
        writer.write(rows)
    writer.close()
    assert written.getvalue().count(b"\n") == 150_001
    picture = plot.read_bytes()
    assert picture.startswith(b"<?xml")
    assert len(picture) < 400_000


def test_a_picture_of_a_file_is_drawn_beside_the_answers(
    stored: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "attitude", stored, data, "--plot", tmp_path / "a.svg")
    assert (outcome.status, len(rows_of(outcome.out))) == (0, len(ATTITUDES))
    assert (tmp_path / "a.svg").read_bytes().startswith(b"<?xml")
    wrong = call(capsys, "attitude", stored, data, "--plot", tmp_path / "a.jpg")
    assert (wrong.status, "the name must end in .svg" in wrong.err) == (2, True)


@pytest.mark.parametrize(
    ("axes", "options", "rolls_deg", "side", "other"),
    [
        ("xy", (), (-60.0, 40.0), "within ±90°", "--no-upright"),
        ("xy", ("--no-upright",), (-120.0, 150.0), "beyond ±90°", "--upright"),
        ("xz", (), (30.0, 150.0), "0° to 180°", "--no-right-wing-down"),
        ("xz", ("--no-right-wing-down",), (-30.0, -150.0), "−180° to 0°", "--right-wing-down"),
    ],
)
def test_two_axes_say_which_of_their_two_answers_is_taken(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str, options: tuple[str, ...],
    rolls_deg: tuple[float, float], side: str, other: str,
) -> None:  # fmt: skip
    rows = [[output_v(axis, TRUTH[axis], 20.0, roll) for axis in axes] for roll in rolls_deg]
    data = tmp_path / "two.csv"
    data.write_text(",".join(f"{axis}_v" for axis in axes) + "\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows))
    named = [part for axis in axes for part in ("--axis", f"{axis}={axis}_v")]
    outcome = call(capsys, "attitude", stored, data, *named, *options)
    found = [float(row["roll_deg"]) for row in csv.DictReader(io.StringIO(outcome.out))]
    assert found == pytest.approx(rolls_deg, abs=1e-6)
    assert f"roll {side} is taken" in " ".join(outcome.err.split())
    assert f"{other} takes that side" in " ".join(outcome.err.split())


@pytest.mark.parametrize("source", ["file", "standard input"])
def test_linear_algebra_has_one_thread_while_rows_are_answered(
    stored: Path, data: Path, source: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two that wait for each other on a busy machine took five times the time."""
    threads: list[int] = []
    answer = Inference.answer

    def watched(found: Inference, readings: Mapping[str, FloatArray]) -> Answer:
        threads.extend(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
        return answer(found, readings)

    monkeypatch.setattr(Inference, "answer", watched)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data.read_bytes())))
    with threadpool_limits(limits=2, user_api="blas"):
        assert call(capsys, "attitude", stored, data if source == "file" else "-").status == 0
    assert set(threads) == {1}
