"""Laws of dialect files: shipped ones are found by increment, an own one is strict."""

from pathlib import Path

import pytest

from rig.errors import DescriptionError
from rig.wire.indexing_table import AskState, Move, TableCodec, TableState
from rig.wire.table_dialect import load_dialect, shipped_dialects

OWN = """
name = "other maker"
increment_deg = 0.5
terminator = "\\n"
identity = { command = "*IDN?", reply = "{text}" }
move = { command = "G{axis},{target_deg:.3f}", reply = "+{axis}" }
home = { command = "H{axis}", reply = "+{axis}" }
stop = { command = "K{axis}", reply = "+{axis}" }
position = { command = "?{axis}", reply = "={axis},{position_deg:.3f}" }
state = { command = "S{axis}", reply = "S{axis}:{words}" }
error = { reply = "!{axis} {text}" }
[words]
resting = "R"
moving = "M"
homed = "Z"
not_homed = "N"
fault = "E"
"""


@pytest.mark.parametrize(
    ("increment_deg", "name"),
    [
        (1.0, "dual-axis-1deg"),
        (5.0, "dual-axis-1deg"),
        (0.5, "single-axis-0.0001deg"),
        (0.0001, "single-axis-0.0001deg"),
    ],
)
def test_the_dialect_follows_from_the_increment(increment_deg: float, name: str) -> None:
    assert load_dialect(None, increment_deg).name == name


def test_an_increment_that_no_shipped_dialect_has_is_refused_with_what_there_is() -> None:
    with pytest.raises(DescriptionError, match=r"got 3e-05°.*dual-axis-1deg \(1°\)"):
        load_dialect(None, 0.00003)


def test_two_dialects_are_shipped() -> None:
    assert set(shipped_dialects()) == {"dual-axis-1deg", "single-axis-0.0001deg"}


def test_a_laboratory_writes_its_own_dialect(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    codec = TableCodec(load_dialect(str(path), 1.0))
    assert codec.encode_command(Move(1, -10.5)) == b"G1,-10.500\n"
    # A dialect without words for a coupling: always seated.
    assert codec.decode_reply(b"S1:R Z", AskState(1)) == TableState(is_moving=False, is_seated=True, is_homed=True)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('name = "other maker"', 'nome = "x"', "nome: unknown key; did you mean name"),
        ("G{axis},{target_deg:.3f}", "G{axis},{angle}", "unknown field {angle}"),
        ("G{axis},{target_deg:.3f}", "G{axis},{position_deg:.3f}", "field {position_deg} has no meaning here"),
        ("={axis},{position_deg:.3f}", "={axis},{position_deg}", "a number needs a format"),
        ('moving = "M"', 'moving = "M"\nseated = ["D"]', "seated and lifted must be as many words"),
    ],
)
def test_a_mistake_in_a_dialect_is_named(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    path = tmp_path / "own.toml"
    assert old in OWN
    path.write_text(OWN.replace(old, new))
    with pytest.raises(DescriptionError) as caught:
        load_dialect(str(path), 1.0)
    assert sentence in str(caught.value)


def test_a_missing_dialect_file_is_named() -> None:
    with pytest.raises(DescriptionError, match="no such file"):
        load_dialect("nowhere.toml", 1.0)
