"""Laws of simulated rigs: the same bits over ports as in memory, and a rig file that reaches them."""

import re
from pathlib import Path

import pytest
from table_bench import rig_file

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig
from rig.errors import DescriptionError
from rig.motion.jog import home, jog_to

FACTOR = 400.0
FAST = (("speed_dps = 5.0", "speed_dps = 30.0"), ("nplc = 10", "nplc = 1"))


def _measured(rig: Rig) -> list[object]:
    wait, found = rig.clock.sleep, []
    for readout in rig.readouts.values():
        readout.prepare()
    for axis in rig.axes:
        home(rig, axis, wait)
    for step, (pitch_deg, roll_deg) in enumerate([(30.0, 60.0), (-90.0, 60.0)]):
        jog_to(rig, "pitch", pitch_deg, wait)
        jog_to(rig, "roll", roll_deg, wait)
        rig.chance.announce(step, "settle", 0, step / 2)
        found.append(rig.readouts["dmm"].read("dmm.x", 2, wait).samples.tolist())
        rig.chance.announce(step, "read", 0, step / 2)
        found += [rig.readouts["dmm"].read(f"dmm.{axis}", 3, wait).samples.tolist() for axis in "xyz"]
        found.append(rig.environments["air"].temperature_degc())
    return found


@pytest.mark.parametrize("pty", [False, True], ids=["tcp", "pty"])
def test_over_ports_the_same_announcements_read_the_same_bits_as_in_memory(tmp_path: Path, pty: bool) -> None:
    path = rig_file(tmp_path, *FAST)
    with open_rig(read_rig(path)) as rig:
        bits = _measured(rig)
    with serve_rig(read_rig(path), ScaledClock(FACTOR), pty=pty) as simulated:
        description = write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
        for _ in range(2):  # and again, on twins that have been used
            with open_rig(description) as rig:
                assert isinstance(rig.clock, ScaledClock)
                assert _measured(rig) == bits


def test_the_addresses_are_those_of_the_published_line(tmp_path: Path) -> None:
    with serve_rig(read_rig(rig_file(tmp_path)), ScaledClock(FACTOR)) as simulated:
        shapes = {key: re.sub(r":\d+", ":N", address) for key, address in simulated.addresses.items()}
        assert shapes == {
            "axes.pitch": "socket://127.0.0.1:N",
            "axes.roll": "socket://127.0.0.1:N",
            "readouts.dmm": "prologix+socket://127.0.0.1:N#22",
            "environment.air": "socket://127.0.0.1:N",
            "twin": "socket://127.0.0.1:N",
        }
        assert simulated.addresses["axes.pitch"] == simulated.addresses["axes.roll"]
        assert len(set(simulated.addresses.values())) == 4


def test_the_written_file_changes_addresses_and_time_only(tmp_path: Path) -> None:
    path = rig_file(tmp_path)
    addresses = {
        "axes.pitch": "socket://127.0.0.1:1",
        "axes.roll": "socket://127.0.0.1:1",
        "readouts.dmm": "prologix+socket://127.0.0.1:2#22",
        "environment.air": "socket://127.0.0.1:3",
        "twin": "socket://127.0.0.1:4",
    }
    written = write_rig(path, addresses, "real", tmp_path / "ports.toml")
    assert not written.uses_twins
    assert written.is_simulated
    before, after = path.read_text().splitlines(), (tmp_path / "ports.toml").read_text().splitlines()
    assert [line for line in after if line not in before] == [
        'port = "socket://127.0.0.1:1"',
        'port = "socket://127.0.0.1:1"',
        'resource = "prologix+socket://127.0.0.1:2#22"',
        'port = "socket://127.0.0.1:3"',
        'control = "socket://127.0.0.1:4"',
        'time = "real"',
    ]
    assert {line for line in before if line not in after} == {'port = "twin"', 'resource = "twin"', 'time = "virtual"'}


def test_a_scanner_of_its_own_follows_the_meter(tmp_path: Path) -> None:
    path = rig_file(tmp_path, ('resource = "twin"\n', 'scanner_resource = "twin"\nresource = "twin"\n'))
    with serve_rig(read_rig(path), ScaledClock(FACTOR)) as simulated:
        written = write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
        with open_rig(written) as rig:
            assert "3488A" in rig.identities()["readouts.dmm"]


def test_a_real_rig_is_simulated_with_its_nominal_sensors(tmp_path: Path) -> None:
    text = (
        rig_file(tmp_path)
        .read_text()
        .split("\n[twin]\n")[0]
        .replace('driver = "watlow-f4"\nport = "twin"', 'driver = "watlow-f4"\nport = "/dev/ttyS2"')
    )
    text = text.replace('port = "twin"', 'port = "/dev/ttyS0"')
    path = tmp_path / "real.toml"
    path.write_text(text.replace('resource = "twin"', 'resource = "prologix+/dev/ttyS1#22"'))
    with serve_rig(read_rig(path), ScaledClock(FACTOR)) as simulated:
        written = write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
        with open_rig(written) as rig:
            assert set(rig.identities()) == {"axes.pitch", "axes.roll", "readouts.dmm", "environment.air"}


def test_a_port_that_cannot_be_edited_is_named_and_nothing_is_written(tmp_path: Path) -> None:
    path = rig_file(tmp_path)
    text = path.read_text()
    section = '[environment.air]\ndriver = "watlow-f4"\nport = "twin"\n'
    assert section in text
    path.write_text(text.replace(section, '[environment]\nair = { driver = "watlow-f4", port = "twin" }\n'))
    with (
        serve_rig(read_rig(path), ScaledClock(FACTOR)) as simulated,
        pytest.raises(DescriptionError, match=r"environment.air: its port cannot be replaced"),
    ):
        write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
    assert not (tmp_path / "ports.toml").exists()
