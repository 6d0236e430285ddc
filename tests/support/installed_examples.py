"""What installing a distribution leaves behind: its modules on the path, and its entry points as its file has them."""

import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest
from example_files import ROOT


def install_example(name: str, site: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install ``examples/NAME`` by its own project file until the test ends; return its folder."""
    folder = ROOT / "examples" / name
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    install(project["name"], project["entry-points"], site, monkeypatch)
    monkeypatch.syspath_prepend(str(folder))
    return folder


def install(
    distribution: str, groups: Mapping[str, Mapping[str, str]], site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Install a distribution of nothing but entry points until the test ends."""
    folder = site / f"{distribution.replace('-', '_')}-1.0.dist-info"
    folder.mkdir(parents=True)
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n", encoding="utf-8")
    sections = [
        "\n".join([f"[{group}]", *(f"{name} = {target}" for name, target in entries.items())])
        for group, entries in groups.items()
    ]
    (folder / "entry_points.txt").write_text("\n".join(sections), encoding="utf-8")
    monkeypatch.syspath_prepend(str(site))
