"""An hour through the live pipe: nothing is lost, memory stays as it is, every spoilt sample is told and no other.

A source hands out second after second of the same text, so an hour of 50 000 rows a second needs no hour and no disk.
"""

import io
import resource
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set, tp_set

from ams.attitude import flag_codes
from ams.frames import body_rates_rad_s
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Package, inference
from procedures.cli.attitude.rows import CsvRows, Rows, RowWriter
from procedures.cli.attitude.stream import answer_stream

ROWS_PER_S, SECONDS = 50_000, 3600
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}
PITCH_DEG, ROLL_DEG, NOISE_V = 20.0, -35.0, 1e-4
SETTLED_ROWS = 3 * ROWS_PER_S
"""Rows after which every buffer has had its size, pyarrow's included."""


def resident_b() -> int:
    """Return the memory of this process, whoever took it."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


class Repeated(io.BytesIO):
    """A header and then the same bytes again and again, in pieces as a pipe hands them out."""

    def __init__(self, header: bytes, of: Callable[[int], bytes], times: int) -> None:
        super().__init__()
        self._pieces: Iterator[bytes] = self._all(header, of, times)

    def read1(self, size: int | None = -1, /) -> bytes:
        return next(self._pieces, b"")

    @staticmethod
    def _all(header: bytes, of: Callable[[int], bytes], times: int) -> Iterator[bytes]:
        yield header
        for turn in range(times):
            text = of(turn)
            for start in range(0, len(text), 200_001):
                yield text[start : start + 200_001]


class Sink(io.BytesIO):
    """Takes everything and keeps nothing."""

    def write(self, content: object, /) -> int:
        return len(content)  # type: ignore[arg-type]


@dataclass
class Seen:
    """Answers counted and passed on to be written."""

    writer: RowWriter
    rows: int = 0
    flags: dict[str, int] = field(default_factory=dict)
    unflagged: list[np.ndarray] = field(default_factory=list)
    """Of the last rows: pitch, its sd."""
    look: Callable[["Seen", Rows], None] | None = None

    def write(self, rows: Rows) -> None:
        if self.look is not None:
            self.look(self, rows)
        counts = np.bincount(rows.indices, minlength=len(rows.words))
        for word, count in zip(rows.words, counts.tolist(), strict=True):
            # A sentence with the number of its line is another one in every row: told by what it says.
            name = word.partition(": ")[2] if word.startswith("line ") else word
            self.flags[name] = self.flags.get(name, 0) + count
        self.rows += rows.indices.size
        self.writer.write(rows)

    def close(self) -> None:
        self.writer.close()


def answered(found: object, source: Repeated, look: Callable[[Seen, Rows], None] | None = None) -> Seen:
    """Answer a source into a sink, with what was seen on the way."""
    sink, kept = Sink(), []

    def writer_of(columns: Sequence[str]) -> tuple[RowWriter, io.BytesIO]:
        kept.append(Seen(CsvRows(sink, columns), look=look))
        return kept[0], sink

    answer_stream(found, writer_of, source)  # type: ignore[arg-type]
    return kept[0]


@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    "seconds", [pytest.param(10, marks=pytest.mark.thorough), pytest.param(SECONDS, marks=pytest.mark.soak)], ids=str
)
def test_an_hour_of_accelerometers_loses_nothing_and_tells_every_spoilt_row(seconds: int) -> None:
    """In every second: a gap of three readings, a rail, a value ten times too large, a torn line and three words."""
    coefficients, chance = tp_set(), np.random.default_rng(31)
    force = -Rotation.from_euler("YX", [PITCH_DEG, ROLL_DEG], degrees=True).inv().apply([0.0, 0.0, 1.0])
    clean = [numbers.primary["offset_v"] + numbers.direction_v_per_g @ force for numbers in coefficients.axes.values()]
    noisy = (np.array(clean) + NOISE_V * chance.normal(size=(ROWS_PER_S, 3))).tolist()
    lines = [",".join(f"{value:.6f}" for value in row) for row in noisy]
    for index in (100, 101, 102):
        lines[index] = ",".join(["nan", *lines[index].split(",")[1:]])
    lines[20_000] = ",".join(["9.99", *lines[20_000].split(",")[1:]])
    lines[30_000] = ",".join(str(10.0 * float(cell)) for cell in lines[30_000].split(","))
    lines[40_000] = lines[40_000][:10]
    lines[49_999] = "no,number,here"
    second = ("\n".join(lines) + "\n").encode()
    wrong: list[float] = []
    settled_b: list[int] = []

    def look(seen: Seen, rows: Rows) -> None:
        if not settled_b and seen.rows >= SETTLED_ROWS:
            settled_b.append(resident_b())
        good = rows.indices == next(index for index, word in enumerate(rows.words) if not word)
        off = np.abs(rows.columns["pitch_deg"][good] - PITCH_DEG) / rows.columns["pitch_sd_deg"][good]
        wrong.append(float(np.max(off, initial=0.0)))

    found = inference(Package(coefficients, COLUMNS), reading_sd_v=NOISE_V)
    seen = answered(found, Repeated(b"x_v,y_v,z_v\n", lambda _: second, seconds), look)
    grown_b = resident_b() - settled_b[0]
    assert seen.rows == seconds * ROWS_PER_S
    assert grown_b < 10e6  # whatever the duration
    flags = seen.flags
    assert flags["x_v no number"] == 3 * seconds
    assert flags["2 cells instead of 3"] == flags["x_v and y_v and z_v no number"] == seconds
    assert sum(count for flag, count in flags.items() if "did not settle" in flag) == 2 * seconds
    alarms = flags["redundancy: outputs disagree"]
    assert alarms <= 0.002 * seen.rows  # 0.1 % by the redundancy's own level
    assert flags[""] + alarms + 7 * seconds == seen.rows
    assert max(wrong) < 6.0


@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    "turns", [pytest.param(2, marks=pytest.mark.thorough), pytest.param(225, marks=pytest.mark.soak)], ids=str
)
def test_an_hour_of_gyros_goes_on_behind_gaps_doubles_and_rubbish(turns: int) -> None:
    """Sixteen seconds of CR's harmonic profile at 1 kHz a turn; once a turn a gap, a double, a NaN and an overrange."""
    gyros, rate_hz, count = gyro_set(), 1000.0, 16_000
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = (np.arange(count) / rate_hz)[:, None] * omega
    euler = 10.0 * np.sin(phase)
    rates = np.rad2deg(body_rates_rad_s(np.deg2rad(euler), np.deg2rad(10.0 * omega * np.cos(phase))))
    outputs = np.stack([n.primary["offset_v"] + rates @ n.direction for n in gyros.axes.values()], axis=-1)
    outputs[9_000] = np.nan
    beyond = next(iter(gyros.axes.values())).primary["offset_v"] + 1.25 * 500.0
    outputs[12_000, 0], outputs[12_001, 0] = beyond, 2.0 * outputs[11_999, 0] - beyond  # cancels: the angle comes back
    cells = [",".join(f"{value:.9f}" for value in row) for row in outputs]

    def turn(number: int) -> bytes:
        rows = [f"{number * 16.0 + index / rate_hz:.3f},{cells[index]}" for index in range(count)]
        del rows[5_000:5_002]
        rows.insert(3_000, rows[2_999])
        return ("\n".join(rows) + "\n").encode()

    ends: list[np.ndarray] = []

    def look(_: Seen, rows: Rows) -> None:
        if rows.indices.size:
            ends.append(np.array([rows.columns[f"{name}_{end}"][-1] for name in ("pitch", "yaw", "roll") for end in
                                  ("deg", "sd_deg")]))  # fmt: skip
            del ends[:-1]

    angles = GyroAngles(GyroPackage(gyros, COLUMNS, 1e-6), Motion(rate_hz))
    seen = answered(angles, Repeated(b"time_s,x_v,y_v,z_v\n", turn, turns), look)
    assert seen.rows == turns * (count - 1)
    found = flag_codes.WORDS
    for word, times in (
        (found[flag_codes.SAMPLES_LOST], 1), (found[flag_codes.NOT_AFTER], 1), (found[flag_codes.RATE_BRIDGED], 1),
        (found[flag_codes.OUTSIDE_RATE], 2),
    ):  # fmt: skip
        assert sum(c for flag, c in seen.flags.items() if word in flag) == times * turns, word
    assert seen.flags[""] == turns * (count - 1 - 5)
    last, expected = ends[-1], euler[-1]
    assert np.all(np.abs(last[::2] - expected) < 4.0 * last[1::2]), (last, expected)
    assert np.all(last[1::2] < 2.0)
