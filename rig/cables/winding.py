"""What is known of how far cables are wound, and how it goes on from one look at the machine to the next.

A look goes on from the last one where the machine kept its count. Where that is not certain nobody knows, and no
later look, move or home makes it known again: only a person does, who removes what is kept.
"""

from dataclasses import dataclass, replace

TURN_DEG = 360.0
HALF_TURN_DEG = TURN_DEG / 2.0
AGREES_DEG = 1.0
"""A read-back that is as close to the remembered one is the same count."""
STEADY_DEG = TURN_DEG / 4.0
"""An axis that turned unseen is so near to where its rate would have brought it, or its turns are not known."""
GOES_ON = 0.1
"""Of its rate: slower than this it stands or is about to, and may have stood for long."""


@dataclass(frozen=True, slots=True)
class Winding:
    """What is known of one axis."""

    wound_deg: float
    """Cumulative angle from where the cables hang free, at the last look."""
    read_deg: float
    """What the machine's own read-back was then."""
    is_turning: bool
    """It was about to turn: since then it may have gone on."""
    is_lost: bool = False
    """Nobody knows how far, until a person has looked and removed what is kept."""


@dataclass(frozen=True, slots=True)
class Machine:
    """What is known of the machine that counts."""

    home_deg: float = 0.0
    """The attitude at its own zero, where a reference move ends."""
    wraps: bool = False
    """Its read-back begins again after a turn: whole turns show only to who looks often enough."""

    def is_wound(self, wound_deg: float) -> bool:
        """Return whether the nearest zero, where a reference move ends, may be another than that of the count."""
        return abs(wound_deg - self.home_deg) > HALF_TURN_DEG - AGREES_DEG

    def may_wind(self, kept: Winding, target_deg: float) -> bool:
        """Return whether a move to a position leads beyond half a turn, or leaves open which way it takes."""
        if self.wraps:
            is_either_way = abs(target_deg - kept.wound_deg) > HALF_TURN_DEG - AGREES_DEG
            return is_either_way or self.is_wound(kept.wound_deg) or self.is_wound(target_deg)
        return self.is_wound(kept.wound_deg) or self.is_wound(target_deg + kept.wound_deg - kept.read_deg)


def nearest_deg(angle_deg: float, to_deg: float) -> float:
    """Return the angle with so many whole turns that it is the nearest to another one."""
    return angle_deg + TURN_DEG * round((to_deg - angle_deg) / TURN_DEG)


def next_look(kept: Winding | None, read_deg: float, machine: Machine) -> Winding:
    """Return what is known after a look that follows another one, with the machine homed in both and between them.

    Whatever winds its cables turns after it was marked as turning: a leap of a wound axis at rest is another count.
    """
    if kept is None or kept.is_lost:
        return first_look(kept, read_deg, machine)
    turned_deg = read_deg - kept.read_deg
    if not kept.is_turning and machine.is_wound(kept.wound_deg) and abs(turned_deg) > AGREES_DEG:
        return replace(kept, is_lost=True)
    return replace(kept, wound_deg=kept.wound_deg + turned_deg, read_deg=read_deg)


def first_look(kept: Winding | None, read_deg: float, machine: Machine) -> Winding:
    """Return what is known after the first look of a process, or the first after the machine had no home.

    The same read-back: it goes on from there. An axis that was turning goes on from the machine's count, however far
    it turned meanwhile, unless that begins again after a turn. Another count of an axis that rested unwound: it was
    moved, or homed anew. Anything else nobody knows.
    """
    anew_deg = nearest_deg(read_deg, machine.home_deg) if machine.wraps else read_deg
    if kept is None:
        return Winding(anew_deg, read_deg, is_turning=False)
    if kept.is_lost:
        return kept
    turned_deg = read_deg - kept.read_deg
    if machine.wraps:
        turned_deg = nearest_deg(turned_deg, 0.0)
        if kept.is_turning:
            return replace(kept, is_lost=True)
    if kept.is_turning or abs(turned_deg) <= AGREES_DEG:
        return replace(kept, wound_deg=kept.wound_deg + turned_deg, read_deg=read_deg)
    if machine.is_wound(kept.wound_deg):
        return replace(kept, is_lost=True)
    return Winding(anew_deg, read_deg, is_turning=False)


def without_home(kept: Winding | None, machine: Machine) -> Winding | None:
    """Return what is known once the machine says that it has no home: only that of cables that rest unwound."""
    if kept is not None and (kept.is_turning or machine.is_wound(kept.wound_deg)):
        return replace(kept, is_lost=True)
    return kept


def differs(kept: Winding, filed: Winding | None, machine: Machine) -> bool:
    """Return whether what is known is more than what a file says, so that the file has to be written."""
    if filed is None:
        return kept.is_lost or machine.is_wound(kept.wound_deg)
    if (kept.is_lost, kept.is_turning) != (filed.is_lost, filed.is_turning):
        return True
    is_wound = machine.is_wound(kept.wound_deg) or machine.is_wound(filed.wound_deg)
    return is_wound and abs(kept.wound_deg - filed.wound_deg) > AGREES_DEG


class UnseenTurns:
    """Tells whether whole turns may have passed uncounted at an axis whose read-back begins again after a turn.

    Seen more often than it can turn by half a turn, it is counted. Seen less often (a long reading, a frozen process)
    it is counted where it turned steadily before and still does behind: what stops does not go on by itself.
    """

    def __init__(self) -> None:
        self._last: tuple[float, float] | None = None
        self._mean_dps = 0.0
        self._fastest_dps = 0.0
        self._is_open = False
        """It turned unseen, and was not seen to go on since."""

    def start(self, speed_dps: float) -> None:
        """Take note that it is about to turn so fast."""
        self._fastest_dps = max(self._fastest_dps, abs(speed_dps))

    def forget(self) -> None:
        """Begin anew, behind a look that does not go on from the last one."""
        self._last, self._fastest_dps, self._is_open = None, 0.0, False

    def is_lost(self, read_deg: float, now_s: float, rate_dps: float, *, is_at_rest: bool) -> bool:
        """Return whether the count to this look is not certain. ``rate_dps``: that it was told last, or 0."""
        last, self._last = self._last, (read_deg, now_s)
        before_dps, fastest_dps = self._mean_dps, self._fastest_dps
        if is_at_rest:
            self._fastest_dps = 0.0
        if last is None:
            return False
        since_s = now_s - last[1]
        if since_s > 0.0:
            self._mean_dps = (read_deg - last[0]) / since_s
        if fastest_dps * since_s >= HALF_TURN_DEG:
            off_deg = max(abs(mean_dps - rate_dps) for mean_dps in (before_dps, self._mean_dps)) * since_s
            self._is_open = True
            return is_at_rest or rate_dps == 0.0 or off_deg > STEADY_DEG
        if self._is_open and (is_at_rest or fastest_dps * since_s >= AGREES_DEG):
            self._is_open = False
            return is_at_rest or abs(self._mean_dps) < GOES_ON * fastest_dps
        return False
