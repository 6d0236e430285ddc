"""How long after a fault the twins' axes really stand still: rig seconds from the fault, in the middle of a move."""

import os
import signal
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from faulty_rig import FaultyRig
from small_run import Bench, bench
from unattended_run import UnattendedRun, asks

from procedures.journal.requests.spool import Request
from procedures.run.begin import begin
from procedures.run.services import RunServices
from rig.abilities.abilities import AxisState
from rig.assembly.open_rig import Rig, open_rig
from rig.errors import LinkLost
from rig.twins.physics.world import World

AFTER_S = 60.0


@dataclass
class StruckRun:
    """One run in the middle of whose next move something happens once."""

    run_dir: Path
    strike: Callable[["StruckRun"], None]
    fault: str = ""
    error: Exception | None = None
    struck_s: float | None = None
    rig: Rig = field(init=False)

    @property
    def world(self) -> World:
        assert isinstance(self.rig.chance, World)
        return self.rig.chance

    def pulse(self) -> tuple[()]:
        """At every look of every wait: strike when the pitch axis is well on its way."""
        now_s = self.rig.clock.monotonic_s()
        if self.struck_s is None and now_s > AFTER_S and self.world.axes["pitch"].rate_dps(now_s) != 0.0:
            self.struck_s = now_s
            self.strike(self)
        return ()

    def look(self, state: AxisState) -> AxisState:
        if self.error is not None:
            raise self.error
        return replace(state, fault=self.fault)

    def still_after_s(self) -> float:
        """From the strike to the last motion of any axis."""
        assert self.struck_s is not None, "nothing happened"
        return max(max(body.still_from_s for body in self.world.axes.values()) - self.struck_s, 0.0)


class RigReopenedLate(FaultyRig):
    """A line that is lost answers to nothing: what is on it is neither stopped nor reached again."""

    def __init__(self, rig: Rig, run: StruckRun) -> None:
        super().__init__(rig, look=run.look)
        self._run = run
        stop = self.pitch.stop

        def refuse() -> None:
            if isinstance(run.error, LinkLost):
                raise run.error
            stop()

        self.pitch.stop = refuse  # type: ignore[method-assign]

    def reconnect(self) -> None:
        if self._run.error is not None:
            raise self._run.error
        super().reconnect()


def _reports(fault: str) -> Callable[[StruckRun], None]:
    return lambda run: setattr(run, "fault", fault)


def _raises(error: Exception) -> Callable[[StruckRun], None]:
    return lambda run: setattr(run, "error", error)


def _asks_abort(run: StruckRun) -> None:
    from procedures.journal.requests.spool import Spool

    Spool(run.run_dir).submit(Request("abort", "anna", "2026-03-01T13:00:00+00:00"))


STRIKES: Mapping[int, Callable[[StruckRun], None]] = {
    18: _raises(ZeroDivisionError("of ours")),
    19: lambda _run: os.kill(os.getpid(), signal.SIGTERM),
    21: _raises(LinkLost("axes.pitch: the port is gone")),
    40: _reports("limit switch"),
    41: _reports("stop button"),
    55: _asks_abort,
}
"""Entry of the catalogue to what happens."""


def standstill_s(entry: int) -> float:
    """Measured on the twins, to a tenth of a second: the same every time, since time is virtual."""
    with TemporaryDirectory() as folder:
        small = _slow(Path(folder))
        run = StruckRun(Path(folder) / "run", STRIKES[entry])
        unattended = UnattendedRun(run.run_dir, at={40: asks("abort")})
        run.run_dir.mkdir()
        with open_rig(small.rig) as rig:
            run.rig = rig
            header = small.header(run.run_dir)
            wrapped = RigReopenedLate(rig, run)
            try:
                begin(run.run_dir, header, small.plan, wrapped, unattended, unattended, RunServices(pulse=run.pulse))  # type: ignore[arg-type]
            except ZeroDivisionError:
                assert entry == 18
            return round(run.still_after_s(), 1)


def _slow(folder: Path) -> Bench:
    """Moves of many seconds."""
    text = (("speed_dps = 180.0", "speed_dps = 5.0"),)
    return bench(folder, rig=text)
