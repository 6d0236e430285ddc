"""Who a device says it is does not depend on the port that it is reached by: a port that changes is no other device."""

from pathlib import Path

import pytest
from key_jobs import jobs
from observed_job import toml_of

from rig.assembly.open_rig import open_rig
from rig.assembly.simulate import at_addresses, serve_rig
from rig.clock import ScaledClock
from rig.description.drivers import TABLES, settings_classes
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

FACTOR = 5.0
QUICK = ("table", "levels")
RIGS = (*QUICK, "daq", "meters", "tilt", "indexing-table", "esp301", "zaber", "pi-gcs", "rate-table")
RIGS += ("oriental-az", "maestro")
BY_HAND = {"manual"}
"""Drivers without a device: nothing answers."""


def _described(name: str, folder: Path) -> RigDescription:
    for file, text in jobs()[name].files.items():
        (folder / file).write_text(text, encoding="utf-8")
    path = folder / "rig.toml"
    path.write_text(toml_of(jobs()[name].rig), encoding="utf-8")
    return read_rig(path)


def _served(rig: RigDescription) -> tuple[dict[str, str], list[str]]:
    with (
        serve_rig(rig, ScaledClock(FACTOR)) as served,
        open_rig(at_addresses(rig, served.addresses, FACTOR)) as opened,
    ):
        return opened.identities(), [address.rpartition(":")[2] for address in served.addresses.values()]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK else pytest.mark.thorough) for name in RIGS]
)
def test_a_twin_on_two_ports_is_one_device(name: str, tmp_path: Path) -> None:
    rig = _described(name, tmp_path)
    (first, ports), (again, _) = _served(rig), _served(rig)
    assert first == again
    assert not [who for who in first.values() for port in ports if port in who]


def test_every_driver_of_a_device_is_among_them(tmp_path: Path) -> None:
    found: dict[str, set[str]] = {table: set() for table in TABLES}
    for number, name in enumerate(RIGS):
        (tmp_path / str(number)).mkdir()
        rig = _described(name, tmp_path / str(number))
        for table in TABLES:
            found[table] |= {device.driver for device in getattr(rig, table, {}).values()}
    for table in TABLES:
        assert found[table] >= set(settings_classes(TABLES[table])) - BY_HAND, table
