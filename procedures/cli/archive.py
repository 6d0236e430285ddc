"""``calrig archive``: what was calibrated, when, with which result."""

from dataclasses import asdict
from typing import Annotated, Any

from cyclopts import App, Parameter

from procedures.cli.output import print_json, say
from procedures.cli.places import default_archive_url

Json = Annotated[bool, Parameter(negative=())]

app = App(name="archive", help="Coefficient sets in the archive.")


@app.command(name="list")
def list_(*, sensor: str | None = None, archive: str | None = None, json: Json = False) -> None:
    """The sets, by sensor, then oldest first.

    Parameters
    ----------
    sensor
        Only this sensor's.
    archive
        URL of the archive, such as sqlite:///archive.sqlite; by default CALRIG_ARCHIVE, else the user's own.
    json
        Print one JSON document.
    """
    from ams.sets.archive import list_sets

    url = archive or default_archive_url()
    rows = list_sets(url, sensor)
    if json:
        print_json({"archive": url, "sets": [_plain(asdict(row)) for row in rows]})
        return
    say(f"{len(rows)} {'set' if len(rows) == 1 else 'sets'} in {url}")
    for row in rows:
        stamp = f"{row.status}{', simulated' if row.simulated else ''}"
        say(f"{row.sha256[:12]}  {row.sensor:<16} {row.created_utc:%Y-%m-%d %H:%M} UTC  {row.model}, {stamp}")


@app.command
def show(key: str, /, *, archive: str | None = None, json: Json = False) -> None:
    """One set: its coefficients with their uncertainties.

    Parameters
    ----------
    key
        A sensor (its latest set), or six or more characters of a checksum.
    archive
        URL of the archive; by default CALRIG_ARCHIVE, else the user's own.
    json
        Print the whole set as one JSON document.
    """
    from ams.sets.archive import show as show_set
    from procedures.cli.coefficients_text import set_text

    found = show_set(archive or default_archive_url(), key)
    if json:
        print_json(found.document)
    else:
        say(set_text(found.document))


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    return {name: value.isoformat() if hasattr(value, "isoformat") else value for name, value in row.items()}
