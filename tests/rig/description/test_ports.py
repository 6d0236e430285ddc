"""Laws of ports in a rig file: what nothing can be reached by, and what cannot share one, is refused with the file."""

from pathlib import Path

import pytest
from small_run import RIG

from rig.description.read import read_rig
from rig.errors import DescriptionError

USB = "/dev/ttyUSB0"
TCP = "socket://192.0.2.7:4001"
AXIS = "limits_deg = [-90.0, 90.0]\nspeed_dps = 5.0\n"
PI = 'driver = "pi-gcs"\naxis_id = "1"\n'
AZ = 'driver = "oriental-az"\nstep_deg = 0.01\n'
ESPEC = 'driver = "ascii-chamber"\nmodel = "espec-p300"\nvalues = "degc"\n'
F4 = 'driver = "watlow-f4"\nunit = 5\n'
F4T = 'driver = "watlow-f4t"\nunit = 6\ntransport = "rtu"\n'
EVEN = 'baud_rate = 19200\nparity = "E"\n'
NONE = 'baud_rate = 19200\nparity = "N"\n'


def _rig(folder: Path, pitch: str, roll: str, air: str) -> Path:
    """The small rig with other devices in three tables; each is driver, keys and port."""
    rest = RIG[RIG.index("[readouts.dmm]") : RIG.index("[environment.air]")] + RIG[RIG.index("[sensors.SN1]") :]
    head = RIG[: RIG.index("[axes.pitch]")]
    path = folder / "rig.toml"
    tables = f"[axes.pitch]\n{AXIS}{pitch}\n[axes.roll]\n{AXIS}{roll}\n[environment.air]\n{air}\n"
    path.write_text(head + tables + rest, encoding="utf-8")
    return path


def _at(keys: str, port: str) -> str:
    return f'{keys}port = "{port}"'


def _read(folder: Path, pitch: tuple[str, str], roll: tuple[str, str], air: tuple[str, str]) -> str:
    """The complaints about three devices, each with its port; empty where there are none."""
    path = _rig(folder, _at(*pitch), _at(*roll), _at(*air))
    try:
        read_rig(path)
    except DescriptionError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    "port",
    [
        "ttyUSB0", "Twin", "TWIN", "", " twin", "dev/ttyUSB0", "./table", "COM", "192.0.2.7:4001", "tcp://192.0.2.7:4001",
        "socket://192.0.2.7", "socket://:4001", "socket://192.0.2.7:0", "socket://192.0.2.7:70000", "rfc2217://host",
        "Socket://192.0.2.7:4001", "Terminal",
    ],
)  # fmt: skip
def test_a_port_that_nothing_opens_is_refused_with_what_is_allowed(tmp_path: Path, port: str) -> None:
    """pyserial took ``ttyUSB0`` for a file beside the command, and refused it when the run began."""
    told = _read(tmp_path, (PI, port), (AZ, "twin"), (F4, "twin"))
    assert "axes.pitch.port: got " in told
    assert 'allowed are "twin", the whole path of a device such as /dev/serial/by-id/… (COM3 on Windows)' in told


@pytest.mark.parametrize(
    "port",
    ["twin", USB, "/dev/serial/by-id/usb-PI-if00", "COM3", "\\\\\\\\.\\\\COM12", TCP, "socket://[2001:db8::7]:4001",
     "socket://table.example:4001/", "rfc2217://192.0.2.7:2217", "rfc2217://192.0.2.7:2217?timeout=3", "loop://",
     "spy:///dev/ttyUSB0", "hwgrep://PI"],
)  # fmt: skip
def test_a_port_that_the_links_open_passes(tmp_path: Path, port: str) -> None:
    assert _read(tmp_path, (PI, port), (AZ, "twin"), (F4, "twin")) == ""


@pytest.mark.parametrize(
    ("pitch", "roll", "air", "told"),
    [
        ((PI, USB), (AZ, USB), (F4, "twin"), "axes.roll.port: /dev/ttyUSB0 is already the port of axes.pitch"),
        ((PI, TCP), (AZ, "twin"), (ESPEC, TCP), "environment.air.port: socket://192.0.2.7:4001 is already the port of"),
        ((PI, "twin"), (AZ, TCP), (ESPEC, TCP), "Modbus RTU there, driver 'ascii-chamber' here"),
        ((PI, TCP), (AZ, "socket://192.0.2.7:4001"), (F4, "twin"), "driver 'pi-gcs' there, Modbus RTU here"),
        ((PI, "twin"), (AZ + EVEN, USB), (F4 + "baud_rate = 19200\n", USB), "parity = E there, N here"),
        ((PI, "twin"), (AZ, USB), (F4, USB), "baud_rate = 115200 there, 9600 here"),
        ((PI, "twin"), (AZ + NONE + "axis = 5\n", USB), (F4 + "baud_rate = 19200\n", USB), "both are unit 5 on it"),
        ((AZ + EVEN, USB), (AZ + NONE + "axis = 2\n", USB), (F4, "twin"), "parity = E there, N here"),
    ],
)
def test_devices_that_cannot_share_a_line_are_refused(
    tmp_path: Path, pitch: tuple[str, str], roll: tuple[str, str], air: tuple[str, str], told: str
) -> None:
    """The first that opened the line gave it its settings, and the others talked into its answers."""
    assert told in _read(tmp_path, pitch, roll, air)


@pytest.mark.parametrize(
    ("pitch", "roll", "air"),
    [
        ((PI, USB), (PI.replace('"1"', '"2"') + "axis = 2\n", USB), (F4, "/dev/ttyUSB1")),
        ((AZ, USB), (AZ + "axis = 2\n", USB), (F4, "twin")),
        ((PI, "twin"), (AZ + NONE, USB), (F4 + "baud_rate = 19200\n", USB)),
        ((PI, "twin"), (AZ, TCP), (F4, TCP)),
        ((AZ + NONE, USB), (AZ + NONE + "axis = 2\n", USB), (F4T + "baud_rate = 19200\n", USB)),
    ],
)
def test_axes_of_one_controller_and_units_of_one_modbus_line_share_it(
    tmp_path: Path, pitch: tuple[str, str], roll: tuple[str, str], air: tuple[str, str]
) -> None:
    """Over a device server the line's settings are the server's."""
    assert _read(tmp_path, pitch, roll, air) == ""


def test_a_link_and_the_device_it_leads_to_are_one_port(tmp_path: Path) -> None:
    (tmp_path / "device").write_text("", encoding="utf-8")
    (tmp_path / "by-id").symlink_to(tmp_path / "device")
    told = _read(tmp_path, (PI, str(tmp_path / "device")), (AZ, str(tmp_path / "by-id")), (F4, "twin"))
    assert "is already the port of axes.pitch; one line has one protocol" in told


@pytest.mark.parametrize(
    ("resource", "told"),
    [
        ("prologix+ttyUSB1#22", "readouts.dmm.resource: got 'ttyUSB1'"),
        (f"prologix+{USB}#22", "readouts.dmm.resource: /dev/ttyUSB0 is already the port of axes.pitch"),
    ],
)
def test_the_adapter_of_a_meter_is_looked_at_as_well(tmp_path: Path, resource: str, told: str) -> None:
    path = _rig(tmp_path, _at(PI, USB), _at(AZ, "twin"), _at(F4, "twin"))
    path.write_text(path.read_text().replace('resource = "twin"', f'resource = "{resource}"'))
    with pytest.raises(DescriptionError) as caught:
        read_rig(path)
    assert told in str(caught.value)


@pytest.mark.parametrize(("rejected", "is_refused"), [((40, 30), True), ((30, 30), True), ((29, 30), False)])
def test_an_interlock_that_could_never_fire_is_refused(
    tmp_path: Path, rejected: tuple[int, int], is_refused: bool
) -> None:
    """It fires where more than ``most`` of the last ``within`` dwells were rejected."""
    path = tmp_path / "rig.toml"
    most, within = rejected
    path.write_text(f"{RIG}[interlocks]\nrejected = {{ most = {most}, within = {within} }}\n", encoding="utf-8")
    if is_refused:
        with pytest.raises(DescriptionError, match=r"interlocks\.rejected\.most: got most = \d+ of within = 30 dwells"):
            read_rig(path)
    else:
        read_rig(path)
