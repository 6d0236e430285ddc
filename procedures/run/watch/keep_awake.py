"""Keep the machine awake while a run runs: systemd's inhibitor, where there is one.

The lock is held by a child that waits for the end of its input, so it ends with this process however that ends.
"""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

HELPER = "systemd-inhibit"
_SETTLE_S = 0.5
"""So long the helper gets to refuse."""


@contextmanager
def awake(why: str) -> Iterator[str]:
    """Forbid suspending; yield an empty text while it is forbidden, else why it is not. Nothing fails for it."""
    program = shutil.which(HELPER)
    if program is None:
        yield f"{HELPER} is not there: forbid suspending yourself (docs/service.md)"
        return
    holder = subprocess.Popen(  # noqa: S603  a fixed program, without a shell
        [program, "--what=sleep:idle:handle-lid-switch", "--who=calrig", f"--why={why}", "--mode=block", "cat"],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip
    try:
        yield _refusal(holder)
    finally:
        assert holder.stdin is not None
        holder.stdin.close()
        try:
            holder.wait(5.0)
        except subprocess.TimeoutExpired:
            holder.kill()
            holder.wait()


def _refusal(holder: subprocess.Popen[bytes]) -> str:
    try:
        status = holder.wait(_SETTLE_S)
    except subprocess.TimeoutExpired:
        return ""
    return f"{HELPER} ended with status {status}: forbid suspending yourself (docs/service.md)"
