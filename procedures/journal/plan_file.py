"""``plan.json`` in a run's folder: the plan for people and their programs. The run goes by the one in its journal."""

from pathlib import Path

from ams.whole_file import write_whole
from procedures.journal.header import RunHeader

PLAN_FILE = "plan.json"


def write_plan(run_dir: Path, header: RunHeader) -> None:
    """Write the plan of the journal beside it. Raises: WriteFailed."""
    write_whole(run_dir / PLAN_FILE, _content(header))


def changed_plan_sentence(run_dir: Path, header: RunHeader) -> str:
    """Say that the file is not the plan of the journal; empty where it is, or where there is none."""
    try:
        is_same = (run_dir / PLAN_FILE).read_bytes() == _content(header)
    except OSError:
        return ""
    sentence = f"{PLAN_FILE} is not the plan of this run, which its journal holds; nothing is taken from it"
    return "" if is_same else sentence


def _content(header: RunHeader) -> bytes:
    return f"{header.plan_json}\n".encode()
