"""``calrig archive export``: a set of the archive for another system."""

from datetime import UTC, datetime
from pathlib import Path

from ams.archive.signatures import set_to_use
from ams.exports.formats import format_named
from ams.sets.dated_ahead import ahead_of_clock
from procedures.cli.locations import archive_url
from procedures.cli.options import Archive, Json, require_folder_of
from procedures.cli.output import note
from procedures.cli.results.export import ToFormat, tell_export
from procedures.delivery.taken_back_sets import require_standing_dwells


def export(key: str, /, *, to: ToFormat, out: Path | None = None, archive: Archive = None, json: Json = False) -> None:
    """Write a set of the archive for another system: as `calrig export` does, and with who approved it by signature.

    A set that was withdrawn is refused, by sensor and by checksum, and one whose dwells were taken back since.

    Parameters
    ----------
    key
        A sensor (its latest set), or six or more characters of a checksum.
    out
        The file to write; by default the sensor's name with the format's ending, in this folder.
    """
    require_folder_of(out, "--out")
    wanted = format_named(to, key)
    url = archive_url(archive)
    found = set_to_use(url, key)
    require_standing_dwells(url, found.sha256, "nothing was written")
    for sentence in ahead_of_clock([found], datetime.now(UTC)):
        note(sentence)
    found.check_vectors(f"archive: set {found.sha256[:12]}")
    tell_export(found, to, out or Path(wanted.file_name(found.sensor)), json=json)
