"""A program of its own: delivers a run in forked children, each killed at one crash point, the last one left alone.

Of its own, because the typesetter keeps threads in a process that has used it, and a fork does not carry them over.
Arguments: the run's folder, the archive's URL, then crash points. Prints which children were killed, as JSON.
"""

import json
import os
import sys
from pathlib import Path

from small_run import in_child

from procedures.delivery.deliver import deliver, solve_run
from rig.crash_points import VARIABLE


def main(folder: Path, archive: str, points: list[str]) -> None:
    killed = [_was_killed(folder, archive, f"{point}:1") for point in points]
    sys.stdout.write(json.dumps([*killed, _was_killed(folder, archive, None)]))


def _was_killed(folder: Path, archive: str, crash: str | None) -> bool:
    def live() -> None:
        if crash is not None:
            os.environ[VARIABLE] = crash
        deliver(solve_run(folder), archive)

    _, ended = os.waitpid(in_child(live), 0)
    assert os.WIFSIGNALED(ended) or os.waitstatus_to_exitcode(ended) == 0, "the child failed by itself"
    return os.WIFSIGNALED(ended)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], sys.argv[3:])
