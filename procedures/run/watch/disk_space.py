"""Room on the disk: how much a run will write, and how much there is."""

import shutil
from pathlib import Path

from procedures.errors import RequestError, StorageFailed
from procedures.plan.plan import Plan

MB = 1e6
_SAMPLE_BYTES = 8
_DWELL_BYTES = 6000
"""Record, two events and their index, measured, rounded up; WAL mode writes every page twice before it is folded."""
_MARGIN = 1.5


def needed_bytes(plan: Plan, dwells: int) -> float:
    """Return what so many more dwells take, with a margin."""
    adaptive = plan.dwell.adaptive
    samples = max(plan.dwell.samples if adaptive is None else adaptive.most_samples, plan.most_samples)
    return _MARGIN * dwells * (_DWELL_BYTES + 2 * _SAMPLE_BYTES * samples * len(plan.channels))


def free_bytes(folder: Path) -> int:
    """Return the free bytes on the folder's disk. Raises: StorageFailed."""
    try:
        return shutil.disk_usage(folder).free
    except OSError as error:
        raise StorageFailed(f"{folder}: its disk does not answer: {error.strerror}; look at the disk") from error


def require_room(folder: Path, plan: Plan, free: int, min_free_mb: float) -> None:
    """Check, before anything is written, that the run has room. Raises: RequestError."""
    needed = needed_bytes(plan, len(plan.dwells)) + min_free_mb * MB
    if free < needed:
        raise RequestError(
            f"{folder}: {free / MB:.1f} MB are free, the run needs {needed / MB:.1f} MB ({len(plan.dwells)} dwells and "
            f"interlocks.min_free_mb = {min_free_mb:g}); nothing was written; free space or give another --out"
        )
