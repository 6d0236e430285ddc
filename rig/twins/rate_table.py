"""Twin of a rate table's controller that speaks a dialect of lines: motors that go to angles and turn on and on.

It comes up with its motors off where the dialect has a command for them, and without a home where it has one. Where a
dialect fetches answers by a later question, it says what it owes before the answer to the next command, as the public
programs for such a table describe it. Where the word of the stop may be obeyed alone or at the end of its line, it is
either machine; each says a prompt to that end.
"""

from collections.abc import Mapping

from rig.twins.physics.servo_axis import ServoAxis
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


class RateTableTwin:
    """A :class:`rig.twins.twin.Twin`. ``bodies``: axis numbers to the world's axis names.

    ``obeys_bare``: it takes the word of a bare command as it comes; otherwise it reads lines.
    """

    def __init__(self, codec: TableCodec, bodies: Mapping[int, str], world: World, *, obeys_bare: bool = True) -> None:
        has_home = codec.knows(Home)
        self.axes = {
            number: ServoAxis(world.axes[name], world, is_homed=not has_home) for number, name in bodies.items()
        }
        self._enabled = set[int]() if codec.knows(Enable) else set(self.axes)
        self._codec = codec
        self._bare = codec.bare_commands() if obeys_bare else frozenset[bytes]()
        self._received = self._due = self._owed = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, rest = self._with_bare_ends(self._received + data).split(self._codec.terminator)
        self._received = rest[-_LONGEST_LINE:]
        for line in lines:
            if line:
                self._take(line, now_s)
            elif self._bare:
                self._due += self._codec.reply_terminator

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        for axis in self.axes.values():
            axis.power_cycle(now_s, is_absolute=not self._codec.knows(Home))

    def _with_bare_ends(self, received: bytes) -> bytes:
        """Put the end that it does not need behind every command that is obeyed without one."""
        for command in self._bare:
            received = received.replace(command, command + self._codec.terminator)
        return received

    def _take(self, line: bytes, now_s: float) -> None:
        self._due, self._owed = self._due + self._owed, b""
        command = self._codec.decode_command(line)
        if command is None:
            self._due += self._codec.encode_reply(Refused("SYNTAX"), 1, None)
            return
        number = getattr(command, "axis", 1)
        reply = self._reply(command, number, now_s)
        if isinstance(command, Rate) and self._codec.knows(Release):
            self._owed = line + self._codec.reply_terminator
        elif isinstance(command, Release):
            self._due += b"0" + self._codec.reply_terminator
        elif self._codec.is_bare(type(command)):
            self._due += b"" if line in self._bare else self._codec.reply_terminator
        else:
            self._due += self._codec.encode_reply(reply, number, type(command))

    def _reply(self, command: Command, number: int, now_s: float) -> Reply:
        if isinstance(command, Identify):
            return Identity(f"CALRIG TWIN RATE TABLE {self._codec.dialect.name} AXES {len(self.axes)}")
        axis = self.axes.get(number)
        if axis is None:
            return Refused("NO SUCH AXIS")
        match command:
            case AskPosition():
                shown_deg = axis.position_deg(now_s)
                return Position(shown_deg % 360.0 if self._codec.dialect.position_wraps else shown_deg)
            case AskState():
                return TableState(axis.is_moving(now_s), is_seated=True, is_homed=axis.is_homed(now_s))
            case Enable():
                self._enabled.add(number)
            case Speed():
                axis.speed_dps = command.speed_dps
            case Stop():
                axis.stop(now_s)
            case Prepare() | Release():
                pass
            case _ if number not in self._enabled:
                return Refused("MOTOR OFF")
            case Move() | Rate() if not axis.is_homed(now_s):
                return Refused("NOT HOMED")
            case Move():
                axis.move(command.target_deg, now_s)
            case Rate() if command.rate_dps:
                axis.spin(command.rate_dps, now_s)
            case Rate():
                axis.stop(now_s)
            case Home():
                axis.home(now_s)
        return Acknowledged()
