"""The example rig with the drives of examples/own_axis as its pitch and roll."""

from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG
from installed_examples import install_example

TABLE = (
    '[axes.{name}]\ndriver = "turner"\nport = "{port}"\naxis = {number}\nlimits_deg = [-40.0, 120.0]\nspeed_dps = 8.0\n'
    "top_rate_dps = 60.0\nsign = -1\nzero_deg = 25.0\n"
)
"""Its home switch is not at attitude 0, and 0 is not the middle of its range."""


def turner_rig(folder: Path, monkeypatch: pytest.MonkeyPatch, port: str = "twin") -> Path:
    """Install the example until the test ends and write ``FOLDER/rig/rig.toml``, which names it; return that."""
    install_example("own_axis", folder / "site", monkeypatch)
    tables = EXAMPLE_RIG.read_text(encoding="utf-8").split("\n\n")
    ours = {
        f"[axes.{name}]": TABLE.format(name=name, port=port, number=number)
        for number, name in enumerate(("pitch", "roll"), start=1)
    }
    file = folder / "rig" / "rig.toml"
    file.parent.mkdir()
    file.write_text("\n\n".join(ours.get(table.partition("\n")[0], table) for table in tables), encoding="utf-8")
    return file
