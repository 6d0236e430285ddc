"""``calrig attitude --view``: the newest attitude on the terminal while rows arrive, with what became of them.

Drawn at most ten times a second, however fast rows come; the figures are of all rows, not of those that were drawn.
"""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ams.frames import ANGLES
from procedures.cli.attitude.rows import Rows, RowWriter
from procedures.jog_screen.panels import ACCENT, BAD, GOOD, QUIET, WARM
from rig.clock import Clock

DRAWN_EVERY_S: Final = 0.1
RATE_OVER_S: Final = 1.0


@dataclass
class Seen:
    """What is shown."""

    angles_deg: Mapping[str, float] = field(default_factory=dict)
    """``pitch_deg``, ``pitch_sd_deg`` and so on of the newest row; an angle that it does not tell is NaN."""
    flag: str = ""
    rows: int = 0
    lost: int = 0
    """Rows without a pitch."""
    flagged: int = 0
    """Rows with a flag, the lost ones among them."""
    rate_hz: float = 0.0


def panel(sensor: str, seen: Seen) -> Group:
    """Return the screen: angles with twice their standard deviation, the flag, rate and loss."""
    table = Table.grid(padding=(0, 2))
    for name in ANGLES:
        if f"{name}_deg" not in seen.angles_deg:
            continue
        value, sd = seen.angles_deg[f"{name}_deg"], seen.angles_deg.get(f"{name}_sd_deg", math.nan)
        is_known = not math.isnan(value)
        shown = Text(f"{value:+11.4f}°" if is_known else "        —", "bold white" if is_known else BAD)
        spread = "" if math.isnan(sd) else f"± {2.0 * sd:.4f}° (k = 2)"
        table.add_row(Text(name, QUIET), shown, Text(spread, QUIET))
    is_good = not seen.flag
    counts = f"{seen.rows} rows   {seen.rate_hz:.0f} /s   {seen.flagged} flagged   {seen.lost} without an attitude"
    return Group(
        Text.assemble(("calrig attitude", f"bold {ACCENT}"), "   ", (sensor, "bold white")),
        table,
        Text("no flag" if is_good else seen.flag, GOOD if is_good else WARM),
        Text(counts, BAD if seen.lost else QUIET),
    )


class ViewedRows:
    """Answers that are shown and, where a writer is given, written as well."""

    def __init__(self, sensor: str, console: Console, clock: Clock, writer: RowWriter | None) -> None:
        self.sensor, self.seen = sensor, Seen()
        self._clock, self._writer = clock, writer
        self._live = Live(panel(sensor, self.seen), console=console, auto_refresh=False)
        self._live.start()
        self._drawn_s = self._counted_s = clock.monotonic_s()
        self._counted = 0

    def write(self, rows: Rows) -> None:
        """Take rows and, where it is time, draw the newest."""
        if self._writer is not None:
            self._writer.write(rows)
        count = rows.indices.size
        if not count:
            return
        pitch, seen = rows.columns["pitch_deg"], self.seen
        seen.angles_deg = {name: float(values[-1]) for name, values in rows.columns.items()}
        seen.flag = rows.words[int(rows.indices[-1])]
        seen.rows += count
        seen.lost += int(np.count_nonzero(np.isnan(pitch)))
        seen.flagged += int(np.count_nonzero(rows.indices))
        now_s = self._clock.monotonic_s()
        if now_s - self._counted_s >= RATE_OVER_S:
            seen.rate_hz = (seen.rows - self._counted) / (now_s - self._counted_s)
            self._counted, self._counted_s = seen.rows, now_s
        if now_s - self._drawn_s >= DRAWN_EVERY_S:
            self._drawn_s = now_s
            self._draw()

    def close(self) -> None:
        """Draw the last row; the screen stays as it is then."""
        if self._writer is not None:
            self._writer.close()
        self._draw()
        with suppress(OSError):  # a terminal that is gone
            self._live.stop()

    def discard(self) -> None:
        """Draw the last row: what was shown cannot be taken back."""
        self.close()

    def _draw(self) -> None:
        with suppress(OSError):  # a terminal that is closed ends no stream of attitudes
            self._live.update(panel(self.sensor, self.seen), refresh=True)
