"""What lines cost on real ports: the processor's share of fast streams, what they lose, and a command of each driver.

The other side runs in a process of its own. Pseudo-terminals hold four kilobytes and never lose: what is not read in
time is late. So the figure that stands for loss is how many of the samples due are missing when the measurement ends.
"""

import json
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.figure import Effort, Figure
from rig.abilities.abilities import Stream
from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import write_rig
from rig.clock import SystemClock
from rig.devices.csv_imu import CsvImuSettings
from rig.devices.csv_imu import connect as connect_csv
from rig.link.ports import open_stream

assert sys.platform != "win32", "it is measured with getrusage"

EXAMPLE = Path(__file__).parents[1] / "examples" / "rig.toml"
POLL_S = 0.005
COMMON = 'port = "twin"\nlimits_deg = [-180.0, 180.0]\nspeed_dps = 5.0\n'
AXES = {
    "indexing-table": "increment_deg = 1.0\n",
    "esp301": "",
    "zaber": "microstep_deg = 0.000234375\n",
    "maestro": "points = [[500.0, -180.0], [2500.0, 180.0]]\npulse_limits_us = [500.0, 2500.0]\n",
    "oriental-az": "step_deg = 0.01\n",
}
IMU = '[streams.imu]\ndriver = "vn100"\nport = "twin"\nbaud_rate = 460800\nrate_hz = 200\n'


def figures(effort: Effort) -> Iterator[Figure]:
    """Per cent of one processor, samples missing, microseconds of the processor a command."""
    with TemporaryDirectory() as folder:
        with _rig(Path(folder), IMU) as rig:
            yield from _streamed(effort, "VN-100, 200 Hz × 12 fields, pty", rig.streams["imu"], 200.0, 5.0)
        for driver in list(AXES)[: effort.amount(len(AXES), 1)]:
            with _rig(Path(folder), "", driver) as rig:
                yield _command(effort, f"{driver}: where is the axis", rig.axes["pitch"].state)
        with _rig(Path(folder), "") as rig:
            yield _command(effort, "watlow-f4: how warm is it", rig.environments["air"].temperature_degc)
    with _child("text", "10000") as path:
        yield from _streamed(effort, "text, 10 kHz × 4 channels, pty", _text_stream(path), 10_000.0, 25.0)


def _text_stream(path: str) -> Stream:
    names = ("a", "b", "c", "d")
    settings = CsvImuSettings.model_validate(
        {
            "driver": "csv-imu",
            "port": path,
            "rate_hz": 10_000.0,
            "columns": ["n", *names],
            "count": {"column": "n", "wraps_at": 65536.0},
            "channels": {name: {"preset": "SCA3000"} for name in names},
        }
    )
    line = open_stream(path, clock=SystemClock(), baud_rate=115200)
    stream = connect_csv("board", settings, line, SystemClock())
    stream.start()
    line.write(b"!")
    return stream


def _streamed(effort: Effort, what: str, stream: Stream, rate_hz: float, target: float) -> Iterator[Figure]:
    clock, lasts_s = SystemClock(), effort.amount(4.0, 0.2)
    stream.start()
    stream.poll()
    began_s, spent_s, samples, missing = clock.monotonic_s(), _spent_s(), 0, 0
    while (now_s := clock.monotonic_s()) < began_s + lasts_s:
        clock.sleep(POLL_S)
        block = stream.poll()
        samples += block.samples
        missing += sum(gap.missing or 0 for gap in block.gaps) + block.refused
    took_s = clock.monotonic_s() - began_s
    late = max(0.0, rate_hz * (now_s - began_s) - samples) / rate_hz * 1e3
    yield Figure(f"{what}, of one processor", 100.0 * (_spent_s() - spent_s) / took_s, "%", target, at_most=True)
    note = f"{samples} samples, {late:.0f} ms behind at the end"
    yield Figure(f"{what}, lost", missing, "", 0, at_most=True, note=note)


def _command(effort: Effort, what: str, ask: Callable[[], object]) -> Figure:
    clock, commands = SystemClock(), effort.amount(100, 3)
    ask()
    began_s, spent_s = clock.monotonic_s(), _spent_s()
    for _ in range(commands):
        ask()
    spent_s, took_s = _spent_s() - spent_s, clock.monotonic_s() - began_s
    note = f"{took_s / commands * 1e3:.2f} ms with line and twin"
    return Figure(what, spent_s / commands * 1e6, "us", 2000.0, at_most=True, note=note)


@contextmanager
def _rig(folder: Path, more: str, driver: str = "") -> Iterator[Rig]:
    """The example on the ports of another process, with other axes."""
    text = EXAMPLE.read_text(encoding="utf-8")
    if driver:
        tables = [table for table in text.split("\n\n") if not table.lstrip().startswith("[axes")]
        axis_lines = f'driver = "{driver}"\n{COMMON}{AXES[driver]}'
        axes = [f"[axes.{name}]\naxis = {number}\n{axis_lines}" for number, name in enumerate(("pitch", "roll"), 1)]
        text = "\n\n".join([*tables, *axes])
    path = folder / f"{driver or 'example'}.toml"
    path.write_text(f"{text}\n\n{more}", encoding="utf-8")
    with _child("rig", str(path)) as addresses:
        written = write_rig(path, json.loads(addresses), "real", folder / "ported.toml")
        with open_rig(written) as rig:
            yield rig


@contextmanager
def _child(*arguments: str) -> Iterator[str]:
    """The first line that it says."""
    command = [sys.executable, "-m", "bench.serve", *arguments]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdin is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.stdin.close()
            process.wait(10.0)


def _spent_s() -> float:
    """By this process, in user and in kernel."""
    spent = resource.getrusage(resource.RUSAGE_SELF)
    return spent.ru_utime + spent.ru_stime
