"""Laws of identities: a device that is another one is refused by name, and so are two that changed places."""

from pathlib import Path

import pytest
from table_bench import example_rig, rig_file

from rig.assembly.discovery import identify_each
from rig.assembly.identity import expected, require_expected
from rig.assembly.open_rig import open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig
from rig.errors import RequestRefused

EXPECTED = {"axes.pitch": "SN 11", "axes.roll": "SN 22"}


def test_devices_that_changed_places_are_named() -> None:
    with pytest.raises(RequestRefused) as refused:
        require_expected(EXPECTED, {"axes.pitch": "stage SN 22", "axes.roll": "stage SN 11"})
    sentence = str(refused.value)
    assert "axes.pitch: another device answers: got 'stage SN 22', which is axes.roll: their cables changed" in sentence
    assert "allowed is one with 'SN 22' (axes.roll: identity)" in sentence
    assert "nothing moved" in sentence


def test_the_right_devices_and_those_of_whom_nothing_is_stated_pass() -> None:
    require_expected(EXPECTED, {"axes.pitch": "stage SN 11", "axes.roll": "stage SN 22", "readouts.dmm": "any"})


def test_nothing_is_expected_of_twins() -> None:
    axes = {name: axis.model_copy(update={"identity": "SN 11"}) for name, axis in example_rig().axes.items()}
    assert not expected(example_rig().model_copy(update={"axes": axes}))


@pytest.fixture
def stated(tmp_path: Path) -> Path:
    """A rig on real ports whose file knows nothing of twins, and means another chamber than the one that answers."""
    return rig_file(tmp_path, ('driver = "watlow-f4"\n', 'driver = "watlow-f4"\nidentity = "steps of 1 degC"\n'))


def test_a_wrong_device_stops_a_session_and_is_seen_among_the_others(stated: Path, tmp_path: Path) -> None:
    with serve_rig(read_rig(stated), ScaledClock(20.0)) as simulated:
        write_rig(stated, simulated.addresses, "real", tmp_path / "ports.toml")
        real = tmp_path / "real.toml"
        real.write_text((tmp_path / "ports.toml").read_text().split("\n[twin]\n")[0], encoding="utf-8")
        description = read_rig(real)
        sentence = r"environment\.air: another device answers: got 'Watlow F4 .* allowed is one with 'steps of 1 degC'"
        with open_rig(description) as rig:
            with pytest.raises(RequestRefused, match=sentence):
                rig.identities()
            with pytest.raises(RequestRefused, match=sentence):
                rig.require_identities()
        request = {device.key: device for device in identify_each(description, real)}
        assert "another device answers" in request["environment.air"].trouble
        assert [key for key, device in request.items() if not device.trouble] == [
            "axes.pitch",
            "axes.roll",
            "readouts.dmm",
        ]
