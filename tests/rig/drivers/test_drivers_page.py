"""The page about drivers: every rig-file example is read by the driver it speaks of, every driver is on the page."""

import re
import tomllib
from pathlib import Path

import pytest

from rig.description.drivers import DESCRIBED_DRIVERS, TABLES, settings_classes

PAGE = (Path(__file__).parents[3] / "docs" / "drivers.md").read_text(encoding="utf-8")
EXAMPLES = [text for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "driver = " in text]
RESTS_ON = PAGE.partition("### What each driver rests on")[2].partition("\n### ")[0]


@pytest.mark.parametrize("text", EXAMPLES, ids=lambda text: text.split("\n", 1)[0])
def test_an_example_is_what_its_driver_accepts(text: str) -> None:
    for table, devices in tomllib.loads(text).items():
        for device in devices.values():
            settings_classes(TABLES[table])[device["driver"]].model_validate(device)  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", sorted(DESCRIBED_DRIVERS))
def test_the_page_says_what_a_driver_rests_on(name: str) -> None:
    (row,) = [line for line in RESTS_ON.splitlines() if line.startswith(f"| `{name}`")]
    _, _, pages, memory, proved, _ = row.split("|")
    assert all(cell.strip() for cell in (pages, memory, proved))
    assert name == "manual" or re.search(r"\(devices/[\w-]+\.md\)", pages)
