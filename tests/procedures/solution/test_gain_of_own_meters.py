"""The gain of a meter is in the uncertainty whoever wrote its driver, or the result says that it is not."""

from pathlib import Path

import pytest
from installed_examples import install_example
from small_run import RIG

from procedures.records.declared_gaps import meter_remarks
from procedures.solution.type_b import shared_errors
from rig.description.device_settings import ReadoutSettings
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

SCANNED = (
    "channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, "
    "z = { scanner = 3, range_v = 10.0 } }"
)
STANDARD = '[standards.meter]\nserial = "1"\ncertificate = "c"\ndue = 2027-06-30\nuncertainty_v = 0.001\n[twin]\n'


@pytest.fixture
def nano(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RigDescription:
    install_example("own_meter", tmp_path / "site", monkeypatch)
    text = RIG.replace(SCANNED, 'standard = "meter"\nchannels = { x = 1, y = 2, z = 3 }')
    text = text.replace('"hp3458a"', '"nano-meter"').replace("[twin]\n", STANDARD)
    (tmp_path / "rig.toml").write_text(text, encoding="utf-8")
    return read_rig(tmp_path / "rig.toml")


def test_a_range_that_is_told_gives_the_gain_its_uncertainty(nano: RigDescription) -> None:
    """A limit of 1 mV over 10 V: 1e-4/√3 of every reading. Source: GUM 4.3.7."""
    errors = {error.name: error.standard_uncertainty for error in shared_errors(nano, nano.sensors["SN1"])["x"]}
    assert errors["multimeter gain"] == pytest.approx(1e-4 / 3.0**0.5)
    assert not meter_remarks(nano, nano.sensors["SN1"])


def test_a_range_that_is_not_told_is_said_of_every_result(nano: RigDescription, monkeypatch) -> None:
    monkeypatch.setattr(type(nano.readouts["dmm"]), "range_of_channel_v", ReadoutSettings.range_of_channel_v)
    assert "multimeter gain" not in {error.name for error in shared_errors(nano, nano.sensors["SN1"])["x"]}
    (said,) = meter_remarks(nano, nano.sensors["SN1"])
    assert "dmm) for its gain" in said.fact
    assert "is in no figure stated here" in said.fact
