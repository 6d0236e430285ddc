"""Where runs stand as Prometheus text, for monitoring that is there already."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from procedures.journal.sidecar.live import Live, read_live
from procedures.journal.status.run_list import ListedRun
from procedures.journal.status.standing import progress_of
from procedures.records.progress import Progress
from procedures.records.states import State

_HELP = {
    "calrig_run_state": "1 for the state in which the run is, 0 for every other.",
    "calrig_run_alive": "1 while a process runs the run.",
    "calrig_run_dwells_done": "Design dwells that count.",
    "calrig_run_dwells_planned": "Design dwells of the plan.",
    "calrig_run_dwells_rejected": "Dwells that do not count.",
    "calrig_run_damaged": "Events and dwells of its journal that are not as they were written; its counts are by it.",
    "calrig_run_end_timestamp_seconds": "When it should end; missing where nothing goes on.",
    "calrig_run_live_timestamp_seconds": "When the engine last said what it does.",
    "calrig_run_temperature_celsius": "As last read, by environment.",
    "calrig_run_soak_left_seconds": "At the least.",
}
Sample = tuple[str, dict[str, str], float]


@dataclass(frozen=True, slots=True)
class RunFigures:
    """One run as monitoring sees it."""

    run: str
    """Name of its folder."""
    progress: Progress | None
    """None where its journal is so damaged that nobody can tell."""
    live: Live | None
    is_alive: bool
    damaged: int | None
    """Events and dwells that are not as they were written; None where the journal was not verified for this."""


def figures_of(listed: Iterable[ListedRun]) -> Iterator[RunFigures]:
    """Return every run of a list that verifies, but for those whose journal cannot be read."""
    for run in listed:
        if not run.trouble:
            progress = None if run.status is None else progress_of("state", run.status)
            yield RunFigures(run.path.name, progress, read_live(run.path), run.is_alive, len(run.damaged))


def metrics_text(runs: Iterable[RunFigures]) -> str:
    """Return the text: one block a metric, one line a run; the same runs give the same text."""
    found: dict[str, list[str]] = {name: [] for name in _HELP}
    for name, labels, value in (sample for run in runs for sample in _samples(run)):
        label_text = ",".join(f'{label}="{_escaped(text)}"' for label, text in labels.items())
        found[name].append(f"{name}{{{label_text}}} {value:.15g}")
    blocks = (
        (f"# HELP {name} {_HELP[name]}", f"# TYPE {name} gauge", *lines) for name, lines in found.items() if lines
    )
    return "".join(f"{line}\n" for block in blocks for line in block)


def _samples(run: RunFigures) -> Iterator[Sample]:
    progress, live, name = run.progress, run.live, {"run": run.run}
    yield "calrig_run_alive", name, float(run.is_alive)
    if run.damaged is not None:
        yield "calrig_run_damaged", name, run.damaged
    if progress is not None:
        for state in State:
            yield "calrig_run_state", {**name, "state": state}, float(state is progress.state)
        yield "calrig_run_dwells_done", name, progress.dwells_done
        yield "calrig_run_dwells_planned", name, progress.dwells_planned
        yield "calrig_run_dwells_rejected", name, progress.rejected
        if progress.eta_utc is not None:
            yield "calrig_run_end_timestamp_seconds", name, progress.eta_utc.timestamp()
    if live is None:
        return
    if live.written_utc is not None:
        yield "calrig_run_live_timestamp_seconds", name, live.written_utc.timestamp()
    for environment, degc in live.temperature_degc.items():
        yield "calrig_run_temperature_celsius", {**name, "environment": environment}, degc
    if live.soak_left_s is not None:
        yield "calrig_run_soak_left_seconds", name, live.soak_left_s


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
