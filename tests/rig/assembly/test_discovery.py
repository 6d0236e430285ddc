from pathlib import Path
from types import SimpleNamespace

import pytest

from rig.assembly.discovery import serial_ports, stable_paths, visa_resources


def test_a_port_is_named_by_its_adapter_and_not_by_the_order_of_plugging(tmp_path: Path) -> None:
    device = tmp_path / "ttyUSB0"
    device.touch()
    by_id = tmp_path / "by-id"
    by_id.mkdir()
    (by_id / "usb-Prologix_GPIB-if00").symlink_to(device)
    assert stable_paths(by_id) == {str(device): str(by_id / "usb-Prologix_GPIB-if00")}


def test_where_the_system_keeps_no_names_the_path_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = [
        SimpleNamespace(device="/dev/ttyUSB1", description="n/a", hwid="n/a"),
        SimpleNamespace(device="/dev/ttyUSB0", description="Prologix GPIB-USB", hwid="USB VID:PID=0403:6001 SER=PX1"),
    ]
    monkeypatch.setattr("rig.assembly.discovery.comports", lambda: found)
    ports = serial_ports(tmp_path / "none")
    assert [(port.path, port.stable_path, port.description, port.hardware) for port in ports] == [
        ("/dev/ttyUSB0", "/dev/ttyUSB0", "Prologix GPIB-USB", "USB VID:PID=0403:6001 SER=PX1"),
        ("/dev/ttyUSB1", "/dev/ttyUSB1", "", ""),
    ]


def test_no_visa_is_told_apart_from_no_instrument() -> None:
    assert visa_resources("/nowhere/libvisa.so@ivi") is None
