"""``calrig archive publish`` and ``demo``: what puts runs, real or made up, into an archive."""

from dataclasses import asdict
from pathlib import Path

import numpy as np

from ams.archive.refusals import without_password
from ams.archive.runs import Override
from ams.archive.synthetic import Story, synthetic_archive
from ams.archive.synthetic_runs import publish_synthetic
from procedures.cli.archive.text import adjustment_lines, plain
from procedures.cli.locations import find_run
from procedures.cli.options import RUNS, Archive, Json, NamedRun, Operator, RunsFolder, require_folder_of
from procedures.cli.output import note, print_json, say
from procedures.cli.run.archive_url import url_of_run
from procedures.delivery.deliver import publish_folder
from procedures.delivery.publish import history_findings
from procedures.errors import RequestError


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
) -> None:
    """Publish a finished run: its sets, as found, as left, the standards behind it. Again, it changes nothing.

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
    folder = find_run(run, out)
    url, published = publish_folder(
        folder, lambda simulated: url_of_run(folder, archive, is_simulated=simulated), word, succession
    )
    if json:
        sets = [plain(asdict(publication)) for publication in published.publications]
        found = {name: plain(asdict(adjustment)) for name, adjustment in published.adjustments.items()}
        print_json({"archive": without_password(url), "sets": sets, "adjustments": found})
        return
    shown = without_password(url)
    for publication in published.publications:
        outcome = "published" if publication.is_new else "was there already"
        say(f"{publication.sha256[:12]}  {publication.sensor:<16} {outcome}   {shown}")
        for line in adjustment_lines(published.adjustments.get(publication.sensor)):
            say(f"  {line}")
    for finding in history_findings(url, published):
        say(f"look at this: {finding}")


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
