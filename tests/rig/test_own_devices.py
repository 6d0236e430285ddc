"""One driver of another distribution for each ability: each keeps the laws that calrig's own keep, on every line."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import pytest
from calrig.testing import DAMAGES, LINES, MISTAKEN, keep_promises, rig_on, survive_damage
from example_files import EXAMPLE_RIG
from installed_examples import install_example

from rig.assembly.open_rig import Rig, open_rig
from rig.defects import defect_text, is_ours
from rig.description.read import read_rig
from rig.drivers.twin_lines import axis_lines
from rig.errors import DescriptionError
from rig.motion.move import home_and_arrive

METER = (
    """driver = "hp3458a"
resource = "twin"
nplc = 10
channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, z = { scanner = 3, range_v = 10.0 } }
""",  # noqa: E501
    'driver = "nano-meter"\nresource = "twin"\nchannels = { x = 1, y = 2, z = 3 }\n',
)  # fmt: skip
AXIS = (
    'driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\n',
    'driver = "turner"\nport = "twin"\ntop_rate_dps = 60.0\n',
)
STREAM = """
[streams.pulse]
driver = "pulse-imu"
port = "twin"
"""
FIELD = """
[field.coil]
driver = "coil-supply"
port = "twin"
limits_ut = [-100.0, 150.0]
ut_per_a = 125.0
"""


@dataclass(frozen=True)
class Example:
    """A folder of ``examples``, the device that it makes of the example rig, and a number that it tells at rest."""

    folder: str
    key: str
    name: str
    """What it says of itself."""
    tells: Callable[[Rig], float]
    changes: tuple[tuple[str, str], ...] = ()
    more: str = ""
    repeats_its_question: bool = False
    factor: float = 100.0
    """Rig seconds in a second of a real port: a stream's samples must pass it."""

    def rig_file(self, folder: Path) -> Path:
        text = EXAMPLE_RIG.read_text(encoding="utf-8")
        for old, new in self.changes:
            assert old in text, old
            text = text.replace(old, new)
        path = folder / "rig.toml"
        path.write_text(text + self.more, encoding="utf-8")
        return path


EXAMPLES = (
    Example(
        "own_driver",
        "environment.air",
        "OVEN-3 SN 17",
        lambda rig: rig.environments["air"].setpoint_degc(),
        (('driver = "watlow-f4"', 'driver = "oven"\nlimits_degc = [-40.0, 85.0]'),),
        repeats_its_question=True,
    ),
    Example(
        "own_meter",
        "readouts.dmm",
        "ACME NANO-7 17 1.0",
        lambda rig: round(float(rig.readouts["dmm"].read("dmm.z", 1, rig.clock.sleep).samples[0]), 2),
        (METER,),
    ),
    Example("own_axis", "axes.pitch", "TURNER 7, drive 1", lambda rig: rig.axes["pitch"].state().position_deg, (AXIS,),
            repeats_its_question=True),
    Example("own_field", "field.coil", "COIL-SUPPLY 3 SN 17",
            lambda rig: rig.fields["coil"].state().applied_ut or 0.0, more=FIELD),
    Example("own_stream", "streams.pulse", "PULSE board", lambda rig: 0.0, more=STREAM, factor=4.0),
)  # fmt: skip


@pytest.fixture(params=EXAMPLES, ids=lambda example: example.folder)
def example(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Example:
    found: Example = request.param
    install_example(found.folder, tmp_path / "site", monkeypatch)
    return found


@pytest.mark.parametrize("line", LINES)
def test_it_keeps_the_laws_of_its_ability(line: str, example: Example, tmp_path: Path) -> None:
    with rig_on(line, example.rig_file(tmp_path), example.factor) as rig:
        keep_promises(rig, example.key)
        assert rig.by_table()[example.key].identify().startswith(example.name)
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".toml"] == ["rig.toml"], "nothing is left"


def test_no_damage_to_its_line_makes_a_wrong_number(example: Example, tmp_path: Path) -> None:
    damages = DAMAGES | MISTAKEN if example.repeats_its_question else DAMAGES
    survive_damage(example.rig_file(tmp_path), example.key, example.tells, 1e-9, damages=damages)


@pytest.fixture
def axis_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    install_example("own_axis", tmp_path / "site", monkeypatch)
    (axis,) = [example for example in EXAMPLES if example.folder == "own_axis"]
    return axis.rig_file(tmp_path)


def test_a_zero_that_is_not_at_home_is_lawful(axis_file: Path) -> None:
    odd = "top_rate_dps = 60.0\nsign = -1\nzero_deg = 30.0\n"
    axis_file.write_text(axis_file.read_text().replace("top_rate_dps = 60.0\n", odd))
    with rig_on("memory", axis_file) as rig:
        keep_promises(rig, "axes.pitch")


def test_drives_of_two_controllers_share_one_line_by_their_addresses(
    axis_file: Path,
) -> None:
    axis_file.write_text(axis_file.read_text().replace("axis = 2\n", "axis = 1\naddress = 3\n"))
    assert axis_lines(read_rig(axis_file).axes) == [("pitch", "roll")]
    with rig_on("memory", axis_file) as rig:
        assert [rig.axes[name].identify() for name in ("pitch", "roll")] == ["TURNER 7, drive 1", "TURNER 7, drive 49"]
        keep_promises(rig, "axes.roll")
    at_a_port = axis_file.read_text().replace('port = "twin"', 'port = "socket://127.0.0.1:1"', 2)
    axis_file.write_text(at_a_port)
    assert read_rig(axis_file).axes["roll"].line_address == (3, 1)
    axis_file.write_text(at_a_port.replace("address = 3\n", ""))
    with pytest.raises(
        DescriptionError, match=r"axes\.roll\.axis: axis 0, 1 at socket://127\.0\.0\.1:1 is already pitch"
    ):
        read_rig(axis_file)


@pytest.mark.parametrize("member", ["stop", "home", "start_rate"])
def test_a_driver_without_a_member_is_refused_before_anything_moves(
    member: str, axis_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(import_module("turner.device").Turner, member)
    sentence = rf"axes.pitch: driver 'turner': its Turner has no {member}, .*; nothing was moved; mend the driver"
    with pytest.raises(DescriptionError, match=sentence):
        open_rig(read_rig(axis_file))


def test_a_bug_in_a_driver_is_told_as_its_own(axis_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    turner = import_module("turner.device")
    monkeypatch.setattr(turner, "nearest_step", None)
    with open_rig(read_rig(axis_file)) as rig:
        home_and_arrive(rig.axes["pitch"], rig.clock, rig.clock.sleep)
        with pytest.raises(TypeError) as caught:
            rig.axes["pitch"].start_move(5.0)
    assert defect_text(caught.value).startswith("a defect of the driver 'turner' of turner 1.0: TypeError: ")
    assert not is_ours(caught.value)
