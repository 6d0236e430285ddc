"""The n-th call fails, n = 1, 2, …: of files with a full disk and with an I/O error, of lines with a broken port. A run
goes on or stops with a sentence; nothing stored is damaged, and a resume ends with the numbers of the clean run."""

import errno
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from device_sets import RIGS, SHORTER, device_set
from failing_files import failing_files
from fault_scripts import tell_of
from killing import Target
from small_run import measured_in, resumed

from procedures.errors import JournalError, StorageFailed
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.states import RESUMABLE, State
from rig.assembly.faulty_lines import drivers_of
from rig.description.fault_plan import FaultPlan

pytestmark = [pytest.mark.timeout(3600), pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")]
"""A write at the close of a connection, whose failure SQLite shrugs off, is told by apsw as unraisable."""
MakeTarget = Callable[[str], Target]
ERRORS = {"full": errno.ENOSPC, "broken": errno.EIO}
FEWEST_CALLS = 300
"""File calls of a whole run."""
FEWEST_QUESTIONS = 800
"""Of a run, to the axes of the line or to the meter: 887 to 3 971 by device."""
SHARES = 16
"""A soak case fails each call or question whose number leaves its share as the rest; all together fail every one."""


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> MakeTarget:
    made: dict[str, Target] = {}

    def make(name: str) -> Target:
        if name not in made:
            folder = tmp_path_factory.mktemp(name)
            made[name] = Target.of(device_set(name, folder, SHORTER), folder)
        return made[name]

    return make


def _fail_files(aimed: Target, calls: Iterable[int], error: int, *, stuck: bool) -> int:
    """One run a call; returns the last call that a run still made."""
    last = 0
    for call in calls:
        run_dir = aimed.new_folder()
        with failing_files(run_dir, call, error, stuck=stuck) as files:
            try:
                state = aimed.bench.run(run_dir).state
            except (StorageFailed, JournalError):
                state = None  # before the first move
        if not files.has_failed:
            return last
        last = call
        _require_recovery(aimed, run_dir, state)
    return last


def _require_recovery(aimed: Target, run_dir: Path, state: State | None) -> None:
    if not (run_dir / JOURNAL_FILE).exists():
        assert state is None, "a run without a journal"
        return
    assert state is None or state in (State.FINISHED, *RESUMABLE), state
    if status(run_dir).state is not State.FINISHED:
        assert resumed(run_dir).state is State.FINISHED
    aimed.require_the_clean_result(run_dir)


@pytest.mark.parametrize(
    "every", [480, pytest.param(160, marks=pytest.mark.thorough), pytest.param(80, marks=pytest.mark.soak)]
)
@pytest.mark.parametrize(
    ("error", "stuck"),
    [
        pytest.param("full", False, id="full-gone"),
        pytest.param("broken", True, id="broken-stuck"),
        pytest.param("full", True, id="full-stuck", marks=pytest.mark.thorough),
        pytest.param("broken", False, id="broken-gone", marks=pytest.mark.thorough),
    ],
)
def test_fault_03_05_the_nth_file_call_fails_and_a_resume_ends_with_the_same_numbers(
    target: MakeTarget, error: str, stuck: bool, every: int
) -> None:
    """The first calls make the journal; then one in so many, another residue for each error."""
    calls = [*range(1, 16, 2), *range(17 + 2 * len(error), 10_000, every)]
    assert _fail_files(target("table-3458a"), calls, ERRORS[error], stuck=stuck) > FEWEST_CALLS


@pytest.mark.soak
@pytest.mark.parametrize("share", range(SHARES))
@pytest.mark.parametrize("stuck", [False, True], ids=["gone", "stuck"])
@pytest.mark.parametrize("error", ERRORS)
def test_fault_03_05_every_file_call_fails_once_and_a_resume_ends_with_the_same_numbers(
    target: MakeTarget, error: str, stuck: bool, share: int
) -> None:
    calls = range(1 + share, 10_000, SHARES)
    assert _fail_files(target("esp301-daq"), calls, ERRORS[error], stuck=stuck) > FEWEST_CALLS


def _break_line(aimed: Target, line: str, piece: int) -> bool:
    """The port breaks at a piece and is there again after 3 s; returns whether the run came so far."""
    rule = {"line": line, "kind": "hang-up", "away_s": 3.0, "on": "question", "nth": piece}
    story = tell_of(aimed.bench, aimed.new_folder(), FaultPlan.model_validate({"fault": {"cut": rule}}))
    if story.outcome is None:
        return True  # cut before there was a run: the rig could not be opened, and said so
    assert story.is_finished, story.outcome
    assert measured_in(story.run_dir) == aimed.clean
    return bool(story.happened)


@pytest.mark.parametrize(
    "every", [399, pytest.param(300, marks=pytest.mark.thorough), pytest.param(150, marks=pytest.mark.soak)]
)
@pytest.mark.parametrize("devices", RIGS)
def test_fault_21_the_nth_question_finds_the_port_gone_and_the_run_ends_with_the_same_numbers(
    target: MakeTarget, devices: str, every: int
) -> None:
    aimed = target(devices)
    lines = [line for line in drivers_of(aimed.bench.rig) if line != "axes.roll"]  # on the line of axes.pitch
    for index, line in enumerate(lines):
        for piece in range(1 + index, 400, every):
            if not _break_line(aimed, line, piece):
                break


@pytest.mark.soak
@pytest.mark.parametrize("share", range(SHARES))
@pytest.mark.parametrize("line", ["axes.pitch", "readouts.dmm"])
@pytest.mark.parametrize("devices", RIGS)
def test_fault_21_every_question_finds_the_port_gone_once(
    target: MakeTarget, devices: str, line: str, share: int
) -> None:
    aimed, piece = target(devices), 1 + share
    while _break_line(aimed, line, piece):
        piece += SHARES
    assert piece > FEWEST_QUESTIONS
