"""The page about drivers: every rig-file example is read by the driver it speaks of, every driver is on the page."""

import re
import tomllib
from pathlib import Path

import pytest

from rig.description.drivers import DRIVERS, TABLES, settings_classes

PAGE = (Path(__file__).parents[3] / "docs" / "drivers.md").read_text(encoding="utf-8")
EXAMPLES = [text for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "driver = " in text]
ELSEWHERE = {"indexing-table", "hp3458a", "watlow-f4"}
"""Drivers that have pages of their own."""


@pytest.mark.parametrize("text", EXAMPLES, ids=lambda text: text.split("\n", 1)[0])
def test_an_example_is_what_its_driver_accepts(text: str) -> None:
    for table, devices in tomllib.loads(text).items():
        for device in devices.values():
            settings_classes(TABLES[table])[device["driver"]].model_validate(device)  # type: ignore[attr-defined]


def test_every_driver_is_on_the_page_or_has_its_own() -> None:
    assert {name for name in set(DRIVERS) - ELSEWHERE if f"`{name}`" not in PAGE} == set()
