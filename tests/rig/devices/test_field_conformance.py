"""What every applied field promises, by every driver and on every line: in memory, over TCP and over a pty."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG

from rig.abilities.abilities import Field, FieldState
from rig.assembly.open_rig import Rig
from rig.description.drivers import settings_classes
from rig.errors import RequestRefused
from rig.testing import LINES, rig_on

TABLES = {"manual": '[field.coil]\ndriver = "manual"\nport = "twin"\nlimits_ut = [-100.0, 100.0]\n'}
"""Driver to its table."""
FACTOR = 100.0


def test_every_field_is_held_to_these_laws() -> None:
    assert set(TABLES) == set(settings_classes("fields"))


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=sorted(TABLES))
def rig(request: pytest.FixtureRequest, line: str, tmp_path: Path) -> Iterator[Rig]:
    path = tmp_path / "rig.toml"
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    path.write_text(text.replace("[twin]\n", f"{TABLES[request.param]}[twin]\n", 1), encoding="utf-8")
    with rig_on(line, path, FACTOR) as opened:
        yield opened


def _applied(field: Field, rig: Rig) -> FieldState:
    for _ in range(1000):
        state = field.state()
        if state.applied_ut is not None or state.fault:
            return state
        rig.clock.sleep(0.5)
    raise AssertionError("never applied")


def test_a_field_keeps_its_promises(rig: Rig) -> None:
    field = rig.fields["coil"]
    assert field.identify()
    assert field.state().applied_ut is None  # nobody knows what was applied before
    for wrong_ut in (100.5, -101.0, float("nan"), float("inf")):
        for refused in (field.check_field, field.start_field):
            with pytest.raises(RequestRefused, match="coil: apply"):
                refused(wrong_ut)
    assert field.state().applied_ut is None
    for field_ut in (50.0, -100.0, 0.0):
        field.start_field(field_ut)
        assert _applied(field, rig) == FieldState(field_ut)
    field.start_field(20.0)
    field.stop()
    rig.clock.sleep(5.0)
    assert field.state().applied_ut is None
    field.start_field(30.0)
    assert _applied(field, rig).applied_ut == 30.0
