"""No ability without laws that every driver of it is held to."""

from pathlib import Path

from motion_bench import DRIVERS

from rig.description.drivers import TABLES, settings_classes

SUITES = {
    "axes": "test_axis_conformance.py",
    "readouts": "test_readout_conformance.py",
    "fields": "test_field_conformance.py",
    "environments": "test_environment_conformance.py",
    "streams": "test_stream_conformance.py",
}


def test_every_axis_is_held_to_the_laws_of_axes() -> None:
    assert set(DRIVERS) == set(settings_classes("axes"))


def test_every_ability_has_its_laws() -> None:
    assert set(TABLES.values()) == set(SUITES)
    assert all((Path(__file__).parent / suite).exists() for suite in SUITES.values())
