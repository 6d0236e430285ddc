"""Laws of rigs with other axes than an indexing table: opened by the rig file, in memory and over real ports alike."""

from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig, rig_from_json
from rig.errors import DescriptionError, RequestRefused
from rig.motion.move import home_and_arrive, move_and_arrive

FACTOR = 50.0
AXES = {
    "esp301": "",
    "maestro": "points = [[500.0, -180.0], [2500.0, 180.0]]\npulse_limits_us = [500.0, 2500.0]",
    "manual": "",
    "oriental-az": "step_deg = 0.01",
    "zaber": "microstep_deg = 0.000234375",
}


def _rig_file(folder: Path, driver: str, port: str = "twin") -> Path:
    """The example with both axes on one controller of ``driver``."""
    head, _, rest = EXAMPLE_RIG.read_text(encoding="utf-8").partition("[axes.pitch]")
    _, mark, tail = rest.partition("[readouts.dmm]")
    tables = "".join(
        f'[axes.{name}]\ndriver = "{driver}"\nport = "{port}"\naxis = {number}\nlimits_deg = [-180.0, 180.0]\n'
        f"speed_dps = 5.0\n{AXES[driver]}\n\n"
        for number, name in enumerate(("pitch", "roll"), start=1)
    )
    path = folder / "rig.toml"
    path.write_text(head + tables + mark + tail, encoding="utf-8")
    return path


def _measured_v(rig: Rig) -> float:
    """The x axis of the package at pitch 30, roll 0."""
    for axis in rig.axes.values():
        home_and_arrive(axis, rig.clock, rig.clock.sleep)
    assert move_and_arrive(rig.axes["pitch"], 30.0, rig.clock, rig.clock.sleep) == pytest.approx(30.0, abs=0.05)
    readout = rig.readouts["dmm"]
    readout.prepare()
    rig.chance.announce(0, "read", 0, 0.0)
    return float(readout.read("dmm.x", 1, rig.clock.sleep).samples[0])


@pytest.mark.parametrize("driver", sorted(AXES))
def test_a_rig_is_opened_moved_and_read(tmp_path: Path, driver: str) -> None:
    description = read_rig(_rig_file(tmp_path, driver))
    assert rig_from_json(description.model_dump_json()).axes == description.axes
    with open_rig(description) as rig:
        assert len(set(rig.identities().values())) == len(rig.identities())
        # S (u·f) + b of the example's x axis: 2.5 V/g, half a g within the coning of a degree.
        assert _measured_v(rig) == pytest.approx(1.25, abs=0.05)


@pytest.mark.parametrize("driver", sorted(set(AXES) - {"manual"}))
@pytest.mark.parametrize("pty", [False, True], ids=["tcp", "pty"])
def test_over_ports_it_stands_where_it_stands_in_memory(tmp_path: Path, driver: str, pty: bool) -> None:
    path = _rig_file(tmp_path, driver)
    with open_rig(read_rig(path)) as rig:
        in_memory_v = _measured_v(rig)
    with serve_rig(read_rig(path), ScaledClock(FACTOR), pty=pty) as simulated:
        description = write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
        with open_rig(description) as rig:
            assert _measured_v(rig) == in_memory_v


def test_a_wrong_calibration_is_refused_with_file_and_line(tmp_path: Path) -> None:
    path = _rig_file(tmp_path, "maestro")
    path.write_text(
        path.read_text(encoding="utf-8").replace("[2500.0, 180.0]", "[2500.0, -200.0]", 1), encoding="utf-8"
    )
    with pytest.raises(DescriptionError, match=r"rig\.toml:\d+: axes\.pitch.*"):
        read_rig(path)


def test_a_manual_axis_needs_a_terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = _rig_file(tmp_path, "manual", "terminal").read_text(encoding="utf-8").replace('"virtual"', '"real"')
    (tmp_path / "rig.toml").write_text(text, encoding="utf-8")
    with Path("/dev/null").open(encoding="utf-8") as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        with pytest.raises(RequestRefused, match="standard input is no terminal"):
            open_rig(read_rig(tmp_path / "rig.toml"))
