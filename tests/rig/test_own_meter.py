"""A readout that is no part of the package keeps what the package's own promise (examples/own_meter)."""

from pathlib import Path

import pytest
from command import call
from example_files import EXAMPLE_RIG
from installed_examples import install_example

from rig.testing import LINES, keep_promises, rig_on

TABLE = '[readouts.dmm]\ndriver = "nano-meter"\nresource = "twin"\nchannels = { x = 1, y = 2, z = 3 }'


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    install_example("own_meter", tmp_path / "site", monkeypatch)
    tables = EXAMPLE_RIG.read_text(encoding="utf-8").split("\n\n")
    file = tmp_path / "rig.toml"
    file.write_text("\n\n".join(TABLE if "[readouts.dmm]" in table else table for table in tables), encoding="utf-8")
    return file


@pytest.mark.parametrize("line", LINES)
def test_it_keeps_the_laws_of_readouts(path: Path, line: str) -> None:
    with rig_on(line, path) as rig:
        keep_promises(rig, "readouts.dmm")
        volts = [float(rig.readouts["dmm"].read(f"dmm.{axis}", 3, rig.clock.sleep).samples.mean()) for axis in "xyz"]
    assert abs(volts[2]) > 1.0  # z points along gravity
    assert max(map(abs, volts[:2])) < 0.1


def test_the_command_knows_it(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "devices", "--rig", path)
    assert outcome.status == 0
    assert "readouts.dmm: ACME NANO-7 17 1.0" in outcome.out
