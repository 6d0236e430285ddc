"""A field that an operator applies: what is asked, answered and stands. The world's own field is the truth."""

import numpy as np
import pytest
from table_bench import example_rig, virtual_clock

from rig.devices.manual_field import ManualFieldSettings, connect
from rig.errors import RequestRefused
from rig.link.memory import MemoryStream
from rig.twins.manual_field import FieldOperatorTwin
from rig.twins.physics.world import World
from rig.wire import manual as wire
from rig.wire.manual import ApplyField

SETTINGS = ManualFieldSettings.model_validate(
    {"driver": "manual", "port": "twin", "limits_ut": [-60.0, 60.0], "direction": [0.0, 3.0, 4.0]}
)


def test_the_operator_reads_a_whole_sentence() -> None:
    line = b"coil: apply a field of 40 uT, then press Enter (or type 'no')\n"
    assert wire.encode(ApplyField("coil", 40.0)) == line
    assert wire.decode(line.decode().rstrip()) == ApplyField("coil", 40.0)
    assert b"switch it off or take it away" in wire.encode(ApplyField("coil", 0.0))


def test_a_field_stands_when_the_operator_has_said_so() -> None:
    clock, world = virtual_clock(), World(example_rig())
    twin = FieldOperatorTwin("coil", SETTINGS.direction, world)
    field = connect("coil", SETTINGS, MemoryStream(twin, clock, "operator"))
    assert field.state().applied_ut is None  # nobody knows before the first answer
    field.start_field(50.0)
    assert field.state().awaits_operator
    clock.sleep(10.0)
    assert field.state().applied_ut == 50.0
    np.testing.assert_allclose(world.stage_field_ut(np.zeros(3), clock.monotonic_s()), (0.0, 30.0, 40.0), atol=1e-3)
    field.start_field(0.0)
    clock.sleep(10.0)
    assert field.state().applied_ut == 0.0
    np.testing.assert_allclose(world.stage_field_ut(np.zeros(3), clock.monotonic_s()), 0.0, atol=1e-12)


def test_what_the_coil_cannot_do_is_not_asked() -> None:
    field = connect(
        "coil", SETTINGS, MemoryStream(FieldOperatorTwin("coil", (0, 0, 1), World(example_rig())), virtual_clock(), "x")
    )
    for wrong in (60.5, float("nan")):
        with pytest.raises(RequestRefused, match=r"allowed -60 to 60 µT \(field\.coil: limits_ut\)"):
            field.start_field(wrong)


def test_no_is_a_fault_and_anything_else_is_asked_again() -> None:
    clock, world = virtual_clock(), World(example_rig())
    twin = FieldOperatorTwin("coil", SETTINGS.direction, world)
    field = connect("coil", SETTINGS, MemoryStream(twin, clock, "operator"))
    twin.answer = "what?"
    field.start_field(10.0)
    clock.sleep(10.0)
    assert field.state().awaits_operator
    twin.answer = "NO"
    clock.sleep(10.0)
    state = field.state()
    assert (state.applied_ut, state.fault) == (None, "the operator could not apply the field")
