"""An axis that the operator sets by hand: cube tumbles, inverted mounts, dividing heads with a crank.

Each step is said in one line; the operator answers with Enter, with the angle that the machine shows, or with ``no``.
Nobody knows where such an axis stands before it was set to its zero, nor after a step that was not finished.
"""

from collections.abc import Mapping, Sequence
from typing import Literal

from rig.abilities.abilities import AxisState, StopStep
from rig.abilities.targets import check_target, require_home
from rig.description.device_settings import AxisSettings
from rig.errors import DeviceNonsense, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.wire import manual as wire
from rig.wire.manual import LeaveIt, Order, SetTo, SetToZero

_LONGEST_ANSWER = 1000


class ManualSettings(AxisSettings):
    """``driver = "manual"``; port ``terminal`` prompts where the command runs."""

    driver: Literal["manual"]

    @property
    def is_set_by_hand(self) -> bool:
        return True

    @property
    def moves_beside_others(self) -> bool:
        """A person is asked for one step at a time."""
        return False


class Prompt:
    """Says one thing at a time over a line and takes one answer, without waiting for it."""

    def __init__(self, stream: ByteStream) -> None:
        self._stream = stream
        self._typed = b""
        self._asker: str | None = None

    @property
    def is_free(self) -> bool:
        return self._asker is None

    def ask(self, order: Order) -> None:
        """Show an order. What was typed before it is no answer to it. Raises: LinkLost."""
        self._asker = order.axis
        self._say(order)

    def tell(self, order: Order) -> None:
        """Show what takes no answer; an open question is withdrawn. Raises: LinkLost."""
        self._asker = None
        self._say(order)

    def answer(self) -> str | None:
        """Return the line that was typed since the question, None while there is none.

        Raises: LinkLost, DeviceNonsense.
        """
        while more := self._stream.read(self._stream.clock.monotonic_s()):
            self._typed += more
        if len(self._typed) > _LONGEST_ANSWER:
            raise DeviceNonsense(f"{self._stream.name}: {len(self._typed)} bytes were typed; is a person at this line?")
        line, end, rest = self._typed.partition(wire.TERMINATOR)
        if not end:
            return None
        self._typed, self._asker = rest, None
        return line.decode("utf-8", errors="replace").strip()

    def _say(self, order: Order) -> None:
        self._stream.discard_input()
        self._typed = b""
        self._stream.write(wire.encode(order))


class ManualAxis:
    """A :class:`rig.abilities.abilities.Axis` whose motor is the operator."""

    def __init__(self, name: str, settings: ManualSettings, prompt: Prompt) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self._settings = settings
        self._prompt = prompt
        self._pending: SetTo | SetToZero | None = None
        self._table_deg = 0.0
        self._is_known = False
        self._fault = ""

    def identify(self) -> str:
        return f"{self.name}, set by the operator"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg)

    def start_move(self, target_deg: float) -> None:
        """Ask the operator. Raises also: RequestRefused while another question is open."""
        self.check_target(target_deg)
        require_home(self.name, f"move to {target_deg:g}°", is_homed=self.state().is_homed)
        self._ask(SetTo(self.name, round(self._settings.table_deg(target_deg), 6)))

    def home(self) -> None:
        """Ask the operator to set the zero of the machine's scale."""
        self._ask(SetToZero(self.name))

    def state(self) -> AxisState:
        self._take_answer()
        return AxisState(
            position_deg=self._settings.attitude_deg(self._table_deg),
            is_moving=self._pending is not None,
            is_homed=self._is_known,
            is_seated=True,
            fault=self._fault,
            awaits_operator=self._pending is not None,
        )

    def stop(self) -> None:
        """Withdraw an open question; the axis may then stand anywhere."""
        if self._pending is not None:
            self._pending, self._is_known = None, False
            self._prompt.tell(LeaveIt(self.name))

    def stop_steps(self) -> Sequence[StopStep]:
        """Return the line that asks the operator to leave it."""
        return (StopStep(wire.encode(LeaveIt(self.name))),)

    def _ask(self, order: SetTo | SetToZero) -> None:
        if not self._prompt.is_free:
            raise RequestRefused(
                f"{self.name}: the operator is asked something else; nothing more was asked; wait for the answer"
            )
        self._fault = ""
        self._prompt.ask(order)
        self._pending = order

    def _take_answer(self) -> None:
        answer = self._prompt.answer() if self._pending is not None else None
        if self._pending is None or answer is None:
            return
        order, self._pending = self._pending, None
        if answer.lower() == wire.CANNOT:
            self._is_known = False
            self._fault = "the operator could not set the axis"
            return
        ordered_deg = order.angle_deg if isinstance(order, SetTo) else 0.0
        entered_deg = wire.decode_angle(answer) if answer and isinstance(order, SetTo) else ordered_deg
        if entered_deg is None or (answer and isinstance(order, SetToZero)):
            self._ask(order)  # not understood: a person reads the line again
            return
        self._table_deg, self._is_known = entered_deg, True


def connect(axes: Mapping[str, ManualSettings], stream: ByteStream) -> dict[str, ManualAxis]:
    """Return the axes that one operator sets."""
    prompt = Prompt(stream)
    return {name: ManualAxis(name, settings, prompt) for name, settings in axes.items()}
