"""``calrig archive publish`` and ``demo``: what puts runs, real or made up, into an archive."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ams.archive.refusals import without_password
from ams.archive.runs import Override, PublishedRun
from ams.archive.sets import Publication, list_sets
from ams.archive.sets import publish as publish_sets
from ams.archive.synthetic import Story, synthetic_archive
from ams.archive.synthetic_runs import publish_synthetic
from ams.exports.formats import load_set
from ams.sets.stated_verdict import Withdrawal
from procedures.cli.archive.text import adjustment_lines, plain
from procedures.cli.locations import JOURNAL, archive_url, find_run
from procedures.cli.options import RUNS, Archive, Json, NamedRun, Operator, RunsFolder, require_folder_of
from procedures.cli.output import note, note_paragraph, print_json, say
from procedures.cli.steer.archive_url import url_of_run
from procedures.delivery.lessons import UNTAUGHT
from procedures.delivery.publish import history_findings
from procedures.delivery.publish_folder import publish_folder
from procedures.errors import ExitStatus, RequestError
from rig.clock import SystemClock


def publish(
    run: NamedRun,
    /,
    *,
    override: str | None = None,
    supersede: str | None = None,
    operator: Operator = None,
    out: RunsFolder = RUNS,
    archive: Archive = None,
    json: Json = False,
) -> ExitStatus:
    """Publish a finished run: its sets, as found, as left, the standards behind it. Again, it changes nothing.

    A coefficient set of `calrig fit --set` is published by its file. It has no run, so nothing is found by it.

    Parameters
    ----------
    override
        Why an expired standard is accepted all the same; needs --operator.
    supersede
        Why this journal takes the place of another one of the same run, as of a copy; needs --operator.
    """
    if (override is None and supersede is None) != (operator is None):
        raise RequestError(
            "an override needs --override REASON and --operator NAME together, a supersession --supersede REASON and "
            "--operator NAME; nothing was published"
        )
    word, succession = (
        Override(operator, why) if why is not None and operator is not None else None for why in (override, supersede)
    )
    if Path(run).is_file() and Path(run).name != JOURNAL:
        _publish_file(Path(run), archive, is_answered_for=operator is not None, json=json)
        return ExitStatus.DONE
    folder = find_run(run, out)
    made = publish_folder(
        folder, lambda simulated: url_of_run(folder, archive, is_simulated=simulated), word, succession
    )
    _tell_published(made.archive_url, made.run, json=json)
    if made.untaught is None:
        return ExitStatus.DONE
    note(f"lessons: {made.untaught}")
    note(UNTAUGHT)
    return ExitStatus.FAILED


def _tell_published(url: str, published: PublishedRun, *, json: bool) -> None:
    gone = _withdrawn(url, published.publications)
    _tell_history(url, published.publications)
    if json:
        sets = [_entry(publication, gone) for publication in published.publications]
        found = {name: plain(asdict(adjustment)) for name, adjustment in published.adjustments.items()}
        print_json({"archive": without_password(url), "sets": sets, "adjustments": found})
        return
    shown = without_password(url)
    for publication in published.publications:
        say(_outcome(publication, gone, shown))
        for line in adjustment_lines(published.adjustments.get(publication.sensor)):
            say(f"  {line}")


def _publish_file(file: Path, archive: str | None, *, is_answered_for: bool, json: bool) -> None:
    """Publish a set that no run made. Raises: RequestError, ams.errors.SetError, ArchiveError."""
    coefficients = load_set(file)
    if is_answered_for:
        raise RequestError(f"{file}: is a set, and --override and --supersede belong to runs; nothing was published")
    if (run_id := coefficients.provenance["run_id"]) is not None:
        raise RequestError(
            f"{file}: is the set of the run {run_id}, which is published whole, with what was found and its standards; "
            f"nothing was published; give the run's folder: calrig archive publish {run_id}"
        )
    if coefficients.is_simulated:
        raise RequestError(
            f"{file}: was measured on a twin, whose sets are archived beside their run only; nothing was published"
        )
    url = archive_url(archive)
    (publication,) = publish_sets(url, [coefficients], SystemClock().now_utc())
    gone = _withdrawn(url, [publication])
    _tell_history(url, [publication])
    if json:
        print_json({"archive": without_password(url), "sets": [_entry(publication, gone)], "adjustments": {}})
        return
    say(_outcome(publication, gone, without_password(url)))


def _tell_history(url: str, publications: Sequence[Publication]) -> None:
    """Tell on standard error what the histories say with what was published just now."""
    for sentence in history_findings(url, publications, SystemClock().now_utc()):
        note_paragraph(f"look at this: {sentence}")


def _withdrawn(url: str, publications: Sequence[Publication]) -> dict[str, Withdrawal]:
    """Return who withdrew which of the sets, by checksum."""
    found = {name: list_sets(url, name) for name in dict.fromkeys(each.sensor for each in publications)}
    return {entry.sha256: entry.withdrawal for rows in found.values() for entry in rows if entry.withdrawal is not None}


def _entry(publication: Publication, gone: Mapping[str, Withdrawal]) -> dict[str, Any]:
    word = gone.get(publication.sha256)
    return {**plain(asdict(publication)), "withdrawal": None if word is None else plain(asdict(word))}


def _outcome(publication: Publication, gone: Mapping[str, Withdrawal], shown: str) -> str:
    outcome = "published" if publication.is_new else "was there already"
    if (word := gone.get(publication.sha256)) is not None:
        outcome = f"was there already, {word}: it must not be used"
    return f"{publication.sha256[:12]}  {publication.sensor:<16} {outcome}   {shown}"


def demo(
    *, out: Path = Path("demo-archive.sqlite"), sensors: int = 50, years: int = 8, seed: int = 1, json: Json = False
) -> None:
    """Make a synthetic archive: sensors that drift, one that dropped, two that were mixed up, a check sensor.

    Parameters
    ----------
    out
        The SQLite file to make; it must not be there yet.
    sensors
        How many, at least 8, calibrated twice a year.
    years
        For how long, at least 4.
    seed
        The same seed makes the same archive.
    """
    if sensors < 8 or years < 4:
        raise RequestError(f"a demonstration needs at least 8 sensors and 4 years: got {sensors} and {years}")
    require_folder_of(out, "--out")
    if out.exists():
        raise RequestError(f"{out}: is there already; give --out with another name; nothing was written")
    url = f"sqlite:///{out}"
    made = synthetic_archive(np.random.default_rng(seed), Story(sensors=sensors, years=years))
    note(f"{out}: calibrating {sensors} sensors for {years} years; this takes a while")
    count = publish_synthetic(url, made, np.random.default_rng(seed + 1))
    planted = {"drifting": made.drifting, "dropped": made.dropped, "mixed_up": made.mixed_up}
    if json:
        print_json(plain({"archive": url, "sets": count, **planted}))
        return
    say(f"{count} sets in {url}")
    for what, names in planted.items():
        say(f"{what.replace('_', ' '):<9} {', '.join(names)}")
    say(f"try: calrig archive history {made.drifting[0]} --archive {url} --plot history.svg")
