"""What the archive says of the sets of a run that a person withdrew since: it stands in place of the run's verdict."""

from ams.archive.sets import Search, list_sets
from ams.errors import ArchiveAbsent


def withdrawn_sentence(archive_url: str, run_id: str) -> str:
    """Return whose sets of a run were withdrawn, by whom, when and why; empty where none was.

    What was published of the run since, as after dwells were taken back and measured again, takes their place.
    Empty too where there is no archive yet. Raises: ArchiveError where it tells nothing: then nobody knows.
    """
    try:
        sets = list_sets(archive_url, search=Search(run_id=run_id))
    except ArchiveAbsent:
        return ""
    latest = {entry.sensor: entry for entry in sets}
    gone = [
        f"the set of {name} is {entry.withdrawal}" for name, entry in latest.items() if entry.withdrawal is not None
    ]
    return f"Not to be used: {'; '.join(gone)}." if gone else ""
