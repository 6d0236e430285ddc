"""A run that ends while an order to move is in doubt: it is named wherever people look, and the end is not called safe.

The order is held on a line that lets what follows overtake it, and comes when nobody is there any more.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from asking import put
from small_run import Bench, bench, dwells_of
from unattended_run import UnattendedRun, events

from procedures.delivery.deliver import deliver, solve_run
from procedures.errors import ExitStatus
from procedures.journal.audit.audit_trail import interruptions_in
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Spool
from procedures.journal.status.status import status
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.handover import handover
from rig.assembly.open_rig import open_rig
from rig.link.byte_stream import ByteStream
from rig.motion.motion_memory import LATEST_S
from rig.twins.physics.world import World

NAMED = "roll: the order to move to "
MAY_COME = " was neither acknowledged nor seen to be taken up, and may still come"


class _HoldsAnOrder:
    """The table's line in memory, that holds the n-th order to move the roll axis and lets all else overtake it."""

    def __init__(self, stream: ByteStream, nth: int, when_held: Callable[[], None]) -> None:
        self._stream, self.left, self._when_held = stream, nth, when_held
        self.name, self.clock = stream.name, stream.clock
        self.held = b""

    def write(self, data: bytes) -> None:
        self.left -= data.startswith(b"2 MOVE")
        if self.left == 0 and not self.held:
            self.held = data
            self._when_held()
        else:
            self._stream.write(data)

    def read(self, deadline_s: float) -> bytes:
        return self._stream.read(deadline_s)

    def discard_input(self) -> bytes:
        return self._stream.discard_input()

    def close(self) -> None:
        self._stream.close()

    def let_go(self) -> None:
        if self.held:
            self._stream.write(self.held)


def _ended(
    small: Bench, run_dir: Path, nth: int, when_held: Callable[[], None] = lambda: None
) -> tuple[Outcome, _HoldsAnOrder, float]:
    """Run until it ends; return also the line, and what roll turns when the order comes at last, degrees."""
    lines: list[_HoldsAnOrder] = []

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        if key != "axes.pitch":
            return open_line()
        lines.append(_HoldsAnOrder(open_line(), nth, when_held))
        return lines[-1]

    unattended = UnattendedRun(run_dir)
    run_dir.mkdir()
    with open_rig(small.rig, line_source=source) as rig:
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig, unattended, unattended)
        (line,) = lines
        line.let_go()
        line.read(rig.clock.monotonic_s() + 1.0)
        rig.clock.sleep(2.0)
        assert isinstance(rig.chance, World)
        stands_deg = rig.chance.attitude_deg("roll", rig.clock.monotonic_s())
        return outcome, line, stands_deg - outcome.positions_deg["roll"]


def test_fault_30_an_order_that_nobody_answered_is_named_at_every_place_where_a_run_tells_of_its_end(
    tmp_path: Path,
) -> None:
    """Detected: the order was sent, and the machine neither answered it nor was seen to take it up.
    Response: the run trips; journal, page, handover, status and report name axis, target and time.
    """
    run_dir = tmp_path / "run"
    ask = partial(put, Spool(run_dir), "abort", "bert", "hands go in")
    outcome, _, turned_deg = _ended(bench(tmp_path), run_dir, 2, ask)
    assert abs(turned_deg) > 5.0, "nothing came late"
    assert (outcome.state, outcome.exit_status, outcome.cause) == (State.TRIPPED, ExitStatus.HELD, "order in doubt")
    assert NAMED in outcome.reason
    assert outcome.reason.endswith(f"{MAY_COME} (asked for by bert)")
    safe = events(run_dir, "safe")[-1].detail
    (doubt,) = safe["in_doubt"]  # type: ignore[misc]
    assert (safe["failures"], doubt.startswith(NAMED), " UTC " in doubt) == ([], True, True)
    stands, page = status(run_dir), (run_dir / "why.txt").read_text(encoding="utf-8")
    report = deliver(solve_run(run_dir), None).report.read_text(encoding="utf-8")
    for told in (stands.held_by, page, handover(run_dir), report):
        assert doubt in told
    assert "Before hands go in, press the stop button" in page
    with JournalReader.open(run_dir) as reader:
        *_, stretch = interruptions_in(reader.events())
    assert "seen to stand" in stretch.axes
    assert stretch.axes.endswith(
        "but an order that no machine answered may still come: go and look before hands go in."
    )


def test_an_order_to_where_its_axis_rests_keeps_no_run_from_its_stop(tmp_path: Path) -> None:
    """It was told again and obeyed; the dwell there is finished before the stop."""
    run_dir = tmp_path / "run"
    outcome, line, turned_deg = _ended(bench(tmp_path), run_dir, 2, partial(put, Spool(run_dir), "stop", "bert", ""))
    assert line.held
    assert (outcome.state, turned_deg) == (State.STOPPED, 0.0)
    assert "in_doubt" not in events(run_dir, "safe")[-1].detail


def test_a_run_that_lost_an_order_on_its_way_does_not_finish_before_it_can_come_no_more(tmp_path: Path) -> None:
    small = bench(tmp_path)
    outcome, line, _ = _ended(small, tmp_path / "clean", 10**6)
    assert outcome.state is State.FINISHED
    orders = 10**6 - line.left
    outcome, _, _ = _ended(small, tmp_path / "lost", orders - 2)
    assert outcome.state is State.FINISHED
    waited_s = [_last_s(tmp_path / name) for name in ("clean", "lost")]
    assert waited_s[0] < 20.0 < LATEST_S / 2.0 < waited_s[1] < LATEST_S + 20.0
    assert "in_doubt" not in events(tmp_path / "lost", "safe")[-1].detail


def _last_s(run_dir: Path) -> float:
    """Return how long the axes stood between the last dwell and the end."""
    return (events(run_dir, "safe")[-1].utc - dwells_of(run_dir)[-1].ended_utc).total_seconds()
