"""``calrig certificate``: the certificate of an approved set, as PDF and page."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

from procedures.certificate.issue import GroundsOf, issue
from procedures.cli.locations import archive_url, person_named
from procedures.cli.options import Archive, Flag, Json, Operator, require_folder
from procedures.cli.output import print_json, say
from procedures.errors import RequestError
from rig.clock import SystemClock

DAY = "%Y-%m-%d"
_EAST_OF_UTC = timedelta(hours=14)
"""Where today begins first."""


def certificate(
    key: str,
    /,
    *,
    number: str,
    operator: Operator = None,
    issued: str | None = None,
    amends: str | None = None,
    reason: str = "",
    specimen: Flag = False,
    out: Path = Path(),
    archive: Archive = None,
    json: Json = False,
) -> None:
    """Issue the certificate of an approved set: PDF/A with the set attached, entered into the archive.

    Parameters
    ----------
    key
        A sensor (its latest set), or six or more characters of a checksum.
    number
        The certificate's number.
    issued
        Day of issue, such as 2026-03-02; by default today.
    amends
        Number of the certificate that this one takes the place of.
    reason
        Why it does; needed with --amends.
    specimen
        Print one to look at, whatever is missing; it is stamped, and the archive does not know of it.
    out
        Folder to write to; by default this one.
    """
    require_folder(out, "--out")
    if (amends is None) != (not reason.strip()):
        raise RequestError("certificate: --amends and --reason belong together; nothing was issued; give both or none")
    now = SystemClock().now_utc()
    day = now if issued is None else _day(issued, now)
    request = GroundsOf(number, day, amends, reason, specimen)
    done = issue(archive_url(archive), key, request, person_named(operator), out)
    if json:
        files = {"page": str(done.page), "paper": str(done.paper), "paper_sha256": done.sha256}
        coefficients = done.grounds.coefficients
        print_json(
            {
                "number": number,
                "specimen": specimen,
                "sensor": coefficients.sensor,
                "set_sha256": coefficients.sha256,
                **files,
            }
        )
        return
    what = "specimen" if specimen else "certificate"
    say(f"{what} {number} of {done.grounds.coefficients.sensor}: {done.paper}")


def _day(text: str, now: datetime) -> datetime:
    try:
        day = datetime.strptime(text, DAY).replace(tzinfo=UTC)
    except ValueError:
        raise RequestError(
            f"--issued: is no day: got {text!r}, allowed is year-month-day such as 2026-03-02; nothing was issued"
        ) from None
    if day > now + _EAST_OF_UTC:
        raise RequestError(f"--issued: got {text}, which is to come: today is {now:{DAY}}; nothing was issued")
    return day
