"""``calrig archive``: what was calibrated, with which result, who stands behind it, what it did over the years."""

from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cyclopts import App

from ams.archive.approvals import WITHDRAWN
from ams.archive.connection import migrate as migrate_archive
from ams.archive.dated_ahead import archived_ahead
from ams.archive.due_list import SENSOR_EVERY_DAYS, due_list
from ams.archive.histories import history as history_of
from ams.archive.refusals import without_password
from ams.archive.run_search import search_runs
from ams.archive.runs import adjustment_of
from ams.archive.sets import Search, list_sets, listed_conditions
from ams.archive.sets import show as show_set
from ams.archive.sign_offs import SignOff
from ams.archive.signatures import accept as accept_finding
from ams.archive.signatures import release as release_set
from ams.archive.signatures import sign as sign_set
from ams.archive.signatures import sign_off, verify_archive
from ams.sets.dated_ahead import ahead_of_clock
from ams.surveillance.compare import compare as compare_sets
from ams.whole_file import write_whole
from procedures.cli.archive.identity import IDENTIFIED_BY_NAME, signer
from procedures.cli.archive.text import (
    adjustment_lines,
    comparison_lines,
    due_lines,
    found_lines,
    history_lines,
    plain,
    set_lines,
    sign_off_lines,
    status_in_words,
    withdrawal_line,
)
from procedures.cli.locations import archive_url
from procedures.cli.options import Archive, Json, Operator, SecretFile, require_folder_of
from procedures.cli.output import note, print_json, say, say_lines
from procedures.cli.results.coefficients_text import set_text
from procedures.delivery.taken_back_sets import require_last_of_run, require_standing_dwells, taken_back_of
from procedures.errors import ExitStatus, RequestError
from procedures.report.history_figure import history_figure
from rig.local_time import local_day

app = App(
    name="archive",
    help="Coefficient sets in the archive: what was found, what was left, and over the years.",
    group_commands="Commands",
)
# What solves loads when it is called: looking takes a third of the time.
app.command(
    "procedures.cli.archive.publish:publish",
    name="publish",
    help="Publish a finished run: its sets, as found, as left, the standards behind it. Again, it changes nothing.",
)
app.command(
    "procedures.cli.archive.export:export",
    name="export",
    help="Write a set of the archive for another system: as calrig export does, and with who approved it by signature.",
)
app.command(
    "procedures.cli.archive.publish:demo",
    name="demo",
    help="Make a synthetic archive: sensors that drift, one that dropped, two that were mixed up, a check sensor.",
)


@app.command(name="list")
def list_(
    *,
    sensor: str | None = None,
    serial: str | None = None,
    rig: str | None = None,
    run: str | None = None,
    since: str | None = None,
    until: str | None = None,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """List the sets, by sensor, then oldest first.

    Parameters
    ----------
    sensor
        Only this sensor's.
    serial
        Only of this serial number.
    rig
        Only what was calibrated on this rig.
    run
        Only of this run.
    since
        Only calibrated on this day (2026-03-01) or later.
    until
        Only calibrated on this day or earlier.
    """
    url = archive_url(archive)
    last = _day("until", until)
    wanted = Search(sensor, serial, rig, run, _day("since", since), None if last is None else last + timedelta(days=1))
    rows, conditions = list_sets(url, search=wanted), listed_conditions(url, wanted)
    if json:
        sets = [plain(asdict(row)) | {"verdict_conditions": conditions.get(row.sha256, "")} for row in rows]
        print_json({"archive": without_password(url), "sets": sets})
        return
    say(f"{len(rows)} {'set' if len(rows) == 1 else 'sets'} in {without_password(url)}")
    for line in set_lines(rows, conditions, datetime.now(UTC)):
        say(line)


@app.command
def due(
    *,
    within_days: int | None = None,
    sensor_every_days: int = SENSOR_EVERY_DAYS,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """List standards and sensors by the day on which they are due.

    Parameters
    ----------
    within_days
        Only what is due within so many days from today, or overdue.
    sensor_every_days
        The interval after which a sensor is calibrated again.
    """
    url, today = archive_url(archive), local_day(datetime.now(UTC))
    known = due_list(url, sensor_every_days)
    found = [
        item
        for item in known
        if within_days is None or ((left := item.days_left(today)) is not None and left <= within_days)
    ]
    if json:
        entries = [{**plain(asdict(item)), "days_left": item.days_left(today)} for item in found]
        print_json({"archive": without_password(url), "due": entries})
        return
    for sentence in archived_ahead(url, [item.name for item in known if item.kind == "sensor"], datetime.now(UTC)):
        note(sentence)
    for line in due_lines(found, today, are_known=bool(known)):
        say(line)


@app.command
def search(*words: str, standard: str | None = None, archive: Archive = None, json: Json = False) -> None:
    """Find runs by any words that are known of them: title, operator, sensor, customer, order, standard, day.

    Parameters
    ----------
    words
        All of them must be known of the run; without any, every run is listed.
    standard
        Only what was measured with the standard of this serial number: what is recalled when it was wrong.
    """
    url = archive_url(archive)
    found = search_runs(url, words, standard)
    if json:
        print_json({"archive": without_password(url), "runs": [plain(asdict(run)) for run in found]})
        return
    say(f"{len(found)} {'run' if len(found) == 1 else 'runs'} in {without_password(url)}, by their first dwells")
    for line in found_lines(found):
        say(line)


@app.command
def show(key: str, /, *, archive: Archive = None, json: Json = False) -> None:
    """Show one set: its coefficients with their uncertainties, as found and as left, and who signed it.

    Parameters
    ----------
    key
        A sensor (its latest set), or six or more characters of a checksum.
    """
    url = archive_url(archive)
    found = show_set(url, key)
    signed = sign_off(url, found.sha256)
    for sentence in ahead_of_clock([found], datetime.now(UTC)):
        note(sentence)
    if taken_back := taken_back_of(url, found.sha256):
        note(f"{taken_back}: it must not be used")
    if json:
        _note_withdrawal(found.sensor, signed)
        print_json(found.document)
        return
    is_signed = found.approval is not None
    status = status_in_words(found.status, found.standing, is_signed=is_signed)
    if signed.withdrawal is not None:
        say(withdrawal_line(found.sensor, signed))
        status = signed.state
    say_lines([set_text(found.document, status, is_withdrawn=signed.withdrawal is not None)])
    say_lines(("", *adjustment_lines(adjustment_of(url, found.sha256)), *sign_off_lines(signed)))


def _note_withdrawal(sensor: str, signed: SignOff) -> None:
    if signed.withdrawal is not None:
        note(withdrawal_line(sensor, signed))


@app.command
def compare(old: str, new: str, /, *, archive: Archive = None, json: Json = False) -> None:
    """Two sets of one sensor: the rotation of a remount first, then what each axis changed.

    Parameters
    ----------
    old
        The older set: six or more characters of its checksum, or a sensor (its latest set).
    new
        The newer set.
    """
    url = archive_url(archive)
    before, after = show_set(url, old), show_set(url, new)
    found = compare_sets(before, after)
    for compared in (before, after):
        _note_withdrawal(compared.sensor, sign_off(url, compared.sha256))
    if json:
        print_json(plain(asdict(found)))
        return
    for line in comparison_lines(found):
        say(line)


@app.command
def history(sensor: str, /, *, archive: Archive = None, plot: Path | None = None, json: Json = False) -> None:
    """Follow a sensor over the years: control charts, what happened to it, advice on its interval.

    Parameters
    ----------
    sensor
        The sensor.
    plot
        Draw the charts into this SVG file.
    """
    require_folder_of(plot, "--plot")
    url = archive_url(archive)
    found, ahead = history_of(url, sensor), archived_ahead(url, [sensor], datetime.now(UTC))
    for label in found.history.labels:
        if taken_back := taken_back_of(url, label.sha256):
            note(f"{taken_back}: it counts here all the same, until calrig solve RUN --archive URL withdraws it")
    if plot is not None:
        write_whole(plot, history_figure(found).svg)
    if json:
        print_json(plain(asdict(found)) | {"dated_ahead": list(ahead)})
    else:
        for line in (*history_lines(found), *ahead):
            say(line)
        if plot is not None:
            say(f"charts       {plot}")


@app.command
def sign(
    key: str,
    role: str,
    /,
    *,
    operator: Operator = None,
    function: str = "",
    comment: str = "",
    secret_file: SecretFile = None,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """Sign a set as prepared, reviewed or approved, in this order and not all by one person; or withdraw it.

    Who signs has an account (`calrig console people`) and tells its secret, at the terminal or by --secret-file.

    Parameters
    ----------
    key
        A sensor (its latest set), or six or more characters of a checksum.
    role
        prepared, reviewed, approved or withdrawn.
    function
        Of who signs, such as "head of the laboratory": certificates have it beside the name.
    comment
        A remark; the reason where a set is withdrawn.
    """
    url = archive_url(archive)
    if role != WITHDRAWN:
        require_standing_dwells(url, key, "nothing was signed")
        require_last_of_run(url, key)
    who = signer(operator, secret_file)
    signed = sign_set(
        url, key, role, who, datetime.now(UTC), comment, function=function, identified_by=IDENTIFIED_BY_NAME
    )
    _tell(signed, json=json)


@app.command
def accept(
    key: str,
    finding: str,
    /,
    *,
    reason: str = "",
    operator: Operator = None,
    secret_file: SecretFile = None,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """Accept a significant finding of a set, or its verdict 'not usable', by name and with a reason.

    Without it the set is not approved.

    Parameters
    ----------
    key
        A sensor (its latest set), or six or more characters of a checksum.
    finding
        The finding's name as archive show tells it, such as x.cubic; 'not usable' for the verdict.
    reason
        Why it does not forbid the use of the set; needed.
    """
    url = archive_url(archive)
    require_standing_dwells(url, key, "nothing was signed")
    who = signer(operator, secret_file)
    _tell(
        accept_finding(url, key, finding, who, datetime.now(UTC), reason, identified_by=IDENTIFIED_BY_NAME), json=json
    )


@app.command
def release(
    key: str,
    /,
    *,
    reason: str = "",
    operator: Operator = None,
    secret_file: SecretFile = None,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """Release a set from quarantine, by name and with a reason: from then on it counts like any other.

    Parameters
    ----------
    key
        Six or more characters of the set's checksum.
    reason
        Why it may be used; needed.
    """
    url = archive_url(archive)
    require_standing_dwells(url, key, "nothing was signed")
    who = signer(operator, secret_file)
    _tell(release_set(url, key, who, datetime.now(UTC), reason, identified_by=IDENTIFIED_BY_NAME), json=json)


@app.command
def verify(*, archive: Archive = None, json: Json = False) -> int:
    """Recompute the hash of every record and every row: whatever was changed behind the record shows."""
    url = archive_url(archive)
    report = verify_archive(url)
    if json:
        print_json({"archive": without_password(url), **plain(asdict(report)), "verified": not report.faults})
    else:
        for fault in report.faults:
            say(fault)
        state = "intact" if not report.faults else f"NOT INTACT: {len(report.faults)} faults"
        extent = f"{report.rows} rows, {report.head.sequence} records, head {report.head.sha256}"
        say(f"{without_password(url)}: {state}; {extent}")
    return ExitStatus.WRONG_REQUEST if report.faults else ExitStatus.DONE


@app.command
def migrate(*, archive: Archive = None) -> None:
    """Bring an older archive up to this version's schema; a copy of a file is written beside it first."""
    url = archive_url(archive)
    before, after = migrate_archive(url)
    say(f"{without_password(url)}: schema {after}{'' if before == after else f', was {before}'}")


def _tell(signed: SignOff, *, json: bool) -> None:
    if json:
        print_json(plain({**asdict(signed), "state": signed.state, "standing": signed.standing}))
        return
    for line in sign_off_lines(signed):
        say(line)


def _day(name: str, text: str | None) -> datetime | None:
    if text is None:
        return None
    try:
        return datetime.fromisoformat(text).replace(tzinfo=UTC)
    except ValueError:
        raise RequestError(f"--{name}: got {text!r}, needed is a day such as 2026-03-01") from None
