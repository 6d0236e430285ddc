"""Twin of an indexing table's controller: one line to talk on, one or more axes, each lifting, turning, seating.

An axis lifts its coupling, turns at its speed, seats and locks; only then it is at rest. It comes up without a home
where its dialect has a search for one, else its positions are absolute. It goes to whole teeth only, and says no by
name. What it turns is a body of the world; what it reports is its own read-back, which a lost home makes wrong.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rig.twins.physics.motion import AxisBody
from rig.twins.physics.world import World
from rig.wire.indexing_table import (
    Acknowledged,
    AskPosition,
    AskState,
    Command,
    Enable,
    Home,
    Identify,
    Identity,
    Move,
    Position,
    Prepare,
    Rate,
    Refused,
    Release,
    Reply,
    Speed,
    Stop,
    TableCodec,
    TableState,
)

_LONGEST_LINE = 256


@dataclass(frozen=True, slots=True)
class TableTimes:
    """How long the coupling takes, and the controller until it shows that a start was taken up."""

    lift_s: float = 0.5
    seat_s: float = 0.8
    shows_s: float = 0.0


class TableAxis:
    """One axis of the controller: what it does with its body over time."""

    def __init__(
        self,
        body: AxisBody,
        world: World,
        travel_deg: tuple[float, float],
        times: TableTimes,
        *,
        is_absolute: bool = False,
    ) -> None:
        self.seats = True
        """False is a coupling that no longer engages: the axis comes to rest lifted."""
        self._body = body
        self._world = world
        self._travel_deg = travel_deg
        self._times = times
        self._shown_from_s = self._rest_from_s = -math.inf
        self._turns_until_s = -math.inf
        self._is_absolute = is_absolute
        self._homed_from_s = -math.inf if is_absolute else math.inf
        self._lost_deg = 0.0
        """True table angle minus read-back: not 0 after the home was lost away from it."""

    def is_moving(self, now_s: float) -> bool:
        return self._shown_from_s <= now_s < self._rest_from_s

    def state(self, now_s: float) -> TableState:
        at_rest = not self.is_moving(now_s)
        return TableState(is_moving=not at_rest, is_seated=at_rest and self.seats, is_homed=self._is_homed(now_s))

    def position_deg(self, now_s: float) -> float:
        lost_deg = 0.0 if self._is_homed(now_s) else self._lost_deg
        return self._body.table_deg(now_s) - lost_deg

    def move(self, target_deg: float, now_s: float) -> Reply:
        refusal = self._refusal(target_deg, now_s)
        if refusal:
            return Refused(refusal)
        if target_deg != self._body.table_deg(now_s):
            self._turn(target_deg, now_s)
        return Acknowledged()

    def home(self, now_s: float) -> Reply:
        if self.is_moving(now_s):
            return Refused("MOVING")
        self._turn(0.0, now_s)
        self._homed_from_s = self._rest_from_s
        return Acknowledged()

    def stop(self, now_s: float) -> Reply:
        """Stop at the next tooth ahead: the coupling seats nowhere else. A home that was on its way is none."""
        if self.is_moving(now_s) and self._homed_from_s > now_s:
            self._homed_from_s = math.inf
        if now_s < self._turns_until_s:
            self._turns_until_s = self._world.rotate(self._body.name, self._next_tooth_deg(now_s), now_s)
            self._rest_from_s = self._turns_until_s + self._times.seat_s
        return Acknowledged()

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back: the axis stands where it was, has no home and reads 0, unless it is absolute."""
        self.stop(now_s)
        if self._is_absolute:
            return
        self._homed_from_s = math.inf
        self._lost_deg = self._body.table_deg(self._rest_from_s)

    def _is_homed(self, now_s: float) -> bool:
        return now_s >= self._homed_from_s

    def _refusal(self, target_deg: float, now_s: float) -> str:
        teeth = target_deg / self._body.increment_deg if self._body.increment_deg else 0.0
        low_deg, high_deg = self._travel_deg
        if self.is_moving(now_s):
            return "MOVING"
        if not self._is_homed(now_s):
            return "NOT HOMED"
        if not low_deg <= target_deg <= high_deg:
            return "OUTSIDE TRAVEL"
        return "OFF INCREMENT" if abs(teeth - round(teeth)) > 1e-6 * max(1.0, abs(teeth)) else ""

    def _turn(self, target_deg: float, now_s: float) -> None:
        self._shown_from_s = now_s + self._times.shows_s
        self._turns_until_s = self._world.rotate(self._body.name, target_deg, now_s + self._times.lift_s)
        self._rest_from_s = self._turns_until_s + self._times.seat_s

    def _next_tooth_deg(self, now_s: float) -> float:
        here_deg, increment_deg = self._body.table_deg(now_s), self._body.increment_deg
        if increment_deg == 0.0:
            return here_deg
        goes_up = self._body.table_deg(self._turns_until_s) > here_deg
        tooth = here_deg / increment_deg
        return (math.ceil(tooth - 1e-9) if goes_up else math.floor(tooth + 1e-9)) * increment_deg


class IndexingTableTwin:
    """The controller: lines in, lines out. A :class:`rig.twins.twin.Twin`."""

    def __init__(
        self,
        codec: TableCodec,
        bodies: Mapping[int, str],
        world: World,
        *,
        travel_deg: tuple[float, float] = (-360.0, 360.0),
        times: TableTimes | None = None,
    ) -> None:
        """Make the table; ``bodies``: the controller's axis numbers to the world's axis names.

        ``travel_deg``: where the dialect does not say what its machine takes.
        """
        takes_deg, is_absolute = codec.dialect.move.targets_deg or travel_deg, not codec.knows(Home)
        self.axes = {
            number: TableAxis(world.axes[name], world, takes_deg, times or TableTimes(), is_absolute=is_absolute)
            for number, name in bodies.items()
        }
        self._codec = codec
        self._received = b""
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, rest = (self._received + data).split(self._codec.terminator)
        self._received = rest[-_LONGEST_LINE:]
        for line in lines:
            self._due += self._answer(line, now_s)

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        for axis in self.axes.values():
            axis.power_cycle(now_s)

    def _answer(self, line: bytes, now_s: float) -> bytes:
        command = self._codec.decode_command(line)
        if command is None:
            return self._codec.encode_reply(Refused("SYNTAX"), _first_number(line), None)
        number = getattr(command, "axis", 0)
        reply = self._reply(command, number, now_s)
        return self._codec.encode_reply(reply, number, type(command))

    def _reply(self, command: Command, number: int, now_s: float) -> Reply:
        if isinstance(command, Identify):
            return Identity(f"CALRIG TWIN INDEXING TABLE {self._codec.dialect.name} AXES {len(self.axes)}")
        axis = self.axes.get(number)
        if axis is None:
            return Refused("NO SUCH AXIS")
        match command:
            case AskPosition():
                return Position(axis.position_deg(now_s))
            case AskState():
                return axis.state(now_s)
            case Move():
                return axis.move(command.target_deg, now_s)
            case Home():
                return axis.home(now_s)
            case Stop():
                return axis.stop(now_s)
            case Rate():
                return Refused("NO RATE")
            case Prepare() | Enable() | Speed() | Release():
                return Acknowledged()


def _first_number(line: bytes) -> int:
    digits = line.split(b" ", 1)[0]
    return int(digits) if digits.isdigit() and len(digits) <= 2 else 0
