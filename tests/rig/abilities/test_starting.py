"""Laws of a start: sent once, whatever becomes of its acknowledgement; settled by asking the machine."""

import pytest

from rig.abilities.starting import start_once
from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent, RigError


class Machine:
    def __init__(self, error: RigError | None, *, starts: bool) -> None:
        self.sent = self.questions = 0
        self._error, self._starts = error, starts

    def send(self) -> None:
        self.sent += 1
        if self._error is not None:
            raise self._error

    def has_started(self) -> bool:
        self.questions += 1
        return self._starts


def test_an_acknowledged_start_asks_nothing() -> None:
    machine = Machine(None, starts=False)
    start_once(machine.send, machine.has_started)
    assert (machine.sent, machine.questions) == (1, 0)


@pytest.mark.parametrize("error", [DeviceSilent("nothing came"), DeviceNonsense("noise")])
def test_a_lost_or_damaged_acknowledgement_is_settled_by_asking(error: RigError) -> None:
    machine = Machine(error, starts=True)
    start_once(machine.send, machine.has_started)
    assert (machine.sent, machine.questions) == (1, 1)
    idle = Machine(error, starts=False)
    with pytest.raises(type(error)):
        start_once(idle.send, idle.has_started)
    assert idle.sent == 1


def test_a_refusal_is_passed_on() -> None:
    machine = Machine(DeviceRefused("not now"), starts=True)
    with pytest.raises(DeviceRefused):
        start_once(machine.send, machine.has_started)
    assert machine.questions == 0
