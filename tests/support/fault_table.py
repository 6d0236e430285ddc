"""``docs/faults.md``, written from the tests: ``python tests/support/fault_table.py`` from the root of the repository.

Every entry of the catalogue has tests named ``test_fault_NN_…``; one of them says in its docstring how the fault is
detected and what the response is. Times to standstill are measured on the twins (:mod:`standstill`).
"""

import ast
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "faults.md"
TITLES: Mapping[int, str] = dict(
    enumerate(
        """process killed at any step
power loss in mid-write
disk full
disk turns read-only or is removed
a sync fails
silent damage in the journal
journal truncated, empty, or none
journal without its write-ahead log
journal on a network or synchronised folder
journal of a newer version
journal of an older version
exported file half written
clock steps
summer time, local time zone
machine suspended
host starved of processor time
memory, files or threads leak
exception in any driver
Ctrl-C once, twice, eleven times; SIGTERM, SIGHUP
the stop itself fails or hangs
line unplugged in mid-command
replugged under another name
two adapters swapped
garbled bytes, wrong baud rate
partial reply, slow trickle
late reply
doubled reply
local echo
stale bytes at open
command in doubt
Modbus exception codes
Modbus TCP: wrong transaction
Modbus RTU: late reply of another register
word order, scale, sign of a register
one device of a bus is mute
library says connected on a dead port
line degrades
two controllers on one rig
soft limit
limit switch in motion
stop button pressed, released
axis stalls
“moving” flag stuck
read-back against command
controller loses its home
home finds the wrong mark
coupling not seated
wrong tooth
backlash
Maestro error bits
servo lags, brown-out
touched, or jogged, during a run
rate wrong, runaway
cable wrap
motion after abort
host dies while an axis turns
meter overload
no number, locale comma
stuck reading
channels swapped
sensor unplugged
polarity, mount turned
noisy dwell
not settled
temperature leaves its band
drift within a replication
samples of a stream missing, doubled, wrapped
wrong sensor
invalid files
files or software changed before a resume
degenerate design""".splitlines(),
        start=1,
    )
) | {
    73: "a command altered on the line",
    74: "frozen, quit, or out of memory while an axis turns",
    75: "a frozen process owns the rig",
    76: "told to end, or aborted",
    77: "the terminal closes",
    78: "a letter that a font lacks",
    79: "a disk that stays full",
    80: "one rig by two names, accounts, hosts",
    81: "moved inside a dwell",
    82: "a run folder is copied and resumed",
    83: "the clock is set during a run",
    84: "secrets of an alert",
    85: "a line that never ends",
    86: "a stop waits for a program to start",
    87: "the link is lost inside the check set",
    88: "all sensors turn at once",
    89: "a run dies, and nobody is told",
    90: "a run does not begin, and nobody looks",
    91: "an axis turns when its line is opened",
    92: "somebody switches a motor off",
    93: "the journal is taken away under a run",
    94: "two read one line of servos",
}
HEAD = """# Faults: how each is met

Written from the tests by `python tests/support/fault_table.py`; a test holds this page and the tests together.
Every entry has tests named `test_fault_NN_…`. *Standstill* is the time from the fault to the last motion of any axis,
measured on the twins in the middle of a move at 5 °/s; — where no axis moves when the fault shows itself. A table whose
line is gone ends its move by itself: how far it was on its way decides.

**Damaged**, in a message, a list or JSON, is what is stored and is not as it was written; it was left as it is, and no
number is drawn from it. `calrig status RUN` and `calrig handover RUN` name events and dwells, and leave
with status 2.

| damaged | what to do |
|---|---|
| a dwell of a run | `calrig salvage RUN` takes the rest into a new folder; a resume there measures it again |
| the journal of a run | a copy of it and its `-wal` file; without one `calrig salvage RUN` takes what is intact |
| a coefficient set or an export | an intact copy, or export it again from the archive ([how](archive.md)) |
| the archive | `calrig archive verify` names the rows; put it back from a copy |
| the file of a queue | keep it for whoever looks into it, and begin a new queue |

| | fault | detected | response | standstill | tests |
|---|---|---|---|---|---|
"""


@dataclass(frozen=True)
class FaultTest:
    """One test of the catalogue."""

    entry: int
    name: str
    file: str
    detected: str
    """Empty where its docstring does not say it."""
    response: str


def fault_tests(folder: Path = ROOT / "tests") -> list[FaultTest]:
    """Every ``test_fault_NN_…``, read from its source."""
    found = []
    for path in sorted(folder.rglob("test_*.py")):
        text = path.read_text(encoding="utf-8")
        if "def test_fault_" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and (named := re.match(r"test_fault_(\d+)_", node.name)):
                said = dict(_fields(ast.get_docstring(node) or ""))
                where = path.relative_to(folder.parent).as_posix()
                found.append(
                    FaultTest(int(named[1]), node.name, where, said.get("Detected", ""), said.get("Response", ""))
                )
    return sorted(found, key=lambda entry: (entry.entry, entry.file, entry.name))


def _fields(docstring: str) -> Iterator[tuple[str, str]]:
    """``Detected:`` and ``Response:`` with their text, over line ends."""
    for name, text in re.findall(r"^(Detected|Response): (.*?)(?=^\w+: |\Z)", docstring, flags=re.M | re.S):
        yield name, " ".join(text.split())


def described(entry: int, tests: list[FaultTest]) -> FaultTest | None:
    """The test that says how this entry is met."""
    return next((test for test in tests if test.entry == entry and test.detected and test.response), None)


def page(tests: list[FaultTest], standstill_s: Mapping[int, float]) -> str:
    """The whole page. Every entry must be described."""
    return HEAD + "".join(_row(entry, tests, standstill_s.get(entry)) for entry in TITLES)


def _row(entry: int, tests: list[FaultTest], seconds: float | None) -> str:
    each, of_entry = described(entry, tests), [test for test in tests if test.entry == entry]
    assert each is not None, f"no test of entry {entry} says how it is detected and answered"
    files = sorted({test.file for test in of_entry})
    links = ", ".join(f"[{Path(file).stem.removeprefix('test_')}](../{file})" for file in files)
    still = "—" if seconds is None else f"{seconds:.1f} s"
    return f"| {entry} | {TITLES[entry]} | {each.detected} | {each.response} | {still} | {links} |\n"


def main() -> None:
    sys.path.insert(0, str(Path(__file__).parent))
    from standstill import STRIKES, standstill_s

    PAGE.write_text(page(fault_tests(), {entry: standstill_s(entry) for entry in STRIKES}), encoding="utf-8")


if __name__ == "__main__":
    main()
