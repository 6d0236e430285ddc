"""Laws of the table of drivers: every built-in driver opens on its twin, and others bring their own parts."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from example_files import EXAMPLE_RIG
from instrument_rigs import daq_and_f4t_rig_file

from rig.assembly.open_rig import Rig, open_rig, real_ports
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.drivers import TABLES, settings_classes
from rig.description.read import read_rig, rig_from_json
from rig.drivers.driver import DRIVERS
from rig.errors import DescriptionError

FACTOR = 400.0


def test_every_built_in_driver_has_devices_and_a_twin_of_each() -> None:
    for driver in DRIVERS.values():
        parts = [driver.axes, driver.readout, driver.environment, driver.stream, driver.field]
        assert any(parts)
        assert all(part.twin is not None for part in parts if part is not None)
        abilities = [ability for ability in TABLES.values() if driver.name in settings_classes(ability)]
        assert len(abilities) == sum(part is not None for part in parts)


def test_reading_a_rig_imports_the_drivers_that_it_names_and_no_other() -> None:
    code = (
        "import sys; from pathlib import Path; from rig.description.read import read_rig; "
        f"read_rig(Path({str(EXAMPLE_RIG)!r})); "
        "print(*sorted(name for name in sys.modules if name.startswith('rig.drivers.')))"
    )
    named = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    own = {"rig.drivers.indexing_table", "rig.drivers.hp3458a", "rig.drivers.watlow_f4"}
    assert {name for name in named if f"{name.rpartition('.')[2].replace('_', '-')}" in DRIVERS} == own


def _measured(rig: Rig) -> list[object]:
    readout, chamber = rig.readouts["dmm"], rig.environments["air"]
    readout.prepare()
    found: list[object] = []
    for step in range(2):
        rig.chance.announce(step, "read", 0, float(step))
        found += [readout.read(f"dmm.{axis}", 3, rig.clock.sleep).samples.tolist() for axis in "xyz"]
        found.append(chamber.temperature_degc())
    chamber.hold(35.0)
    found.append(chamber.setpoint_degc())
    return found


@pytest.mark.parametrize("pty", [False, True], ids=["tcp", "pty"])
def test_over_ports_the_other_instruments_read_the_same_bits_as_in_memory(tmp_path: Path, pty: bool) -> None:
    path = daq_and_f4t_rig_file(tmp_path, streams=False)  # at this factor they would send tens of thousands a second
    with open_rig(read_rig(path)) as rig:
        bits = _measured(rig)
    with serve_rig(read_rig(path), ScaledClock(FACTOR), pty=pty) as simulated:
        description = write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
        assert len(real_ports(description)) == 3  # table, unit, chamber
        with open_rig(description) as rig:
            assert _measured(rig) == bits


def test_streams_of_a_rig_tell_gravity_and_stand_in_its_identities(tmp_path: Path) -> None:
    description = read_rig(daq_and_f4t_rig_file(tmp_path))
    with open_rig(description) as rig:
        assert rig.identities()["streams.imu"].startswith("VectorNav VN-100T-CR")
        for stream in rig.streams.values():
            stream.start()
        rig.clock.sleep(2.0)
        blocks = {name: stream.poll() for name, stream in rig.streams.items()}
    assert {name: block.samples for name, block in blocks.items()} == pytest.approx({"imu": 401, "board": 100}, abs=1)
    np.testing.assert_allclose(blocks["imu"].values["imu.az"], -9.807, atol=0.001)
    np.testing.assert_allclose(blocks["board"].values["board.az"], -1.0, atol=0.004)
    assert rig_from_json(description.model_dump_json()).model_dump() == description.model_dump()


def test_a_stream_in_the_file_is_checked_with_its_line(tmp_path: Path) -> None:
    path = daq_and_f4t_rig_file(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace("rate_hz = 200", "rate_hz = 60"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"wider\.toml:\d+: streams\.imu\.rate_hz: .*no rate of 60 Hz"):
        read_rig(path)
