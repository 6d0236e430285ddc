"""The kinds of design that calrig brings, each registered in ``pyproject.toml``."""

from procedures.description.described_designs import SETS
from procedures.plan import designs
from procedures.plan.design_kind import DesignKind, Wanted
from procedures.plan.designs import Design


def _fractional(wanted: Wanted) -> Design:
    assert wanted.table.fractional is not None
    return designs.fractional(wanted.pitch_deg, wanted.roll_deg, wanted.table.fractional)


def _file(wanted: Wanted) -> Design:
    assert wanted.table.file is not None
    return designs.read_points(wanted.folder / wanted.table.file)


def _factorial(wanted: Wanted) -> Design:
    table = wanted.table
    return designs.factorial(
        designs.FACTORIAL_PITCH_DEG if table.pitch_deg is None else wanted.pitch_deg,
        designs.uniform_circle_deg(designs.FACTORIAL_LEVELS[1]) if table.roll_deg is None else wanted.roll_deg,
    )


D = DesignKind(name="D", make=lambda wanted: designs.full_grid(wanted.pitch_deg, wanted.roll_deg))
D0 = DesignKind(name="D0", make=lambda wanted: designs.uniform_roll(wanted.pitch_deg, wanted.roll_deg))
D1 = DesignKind(name="D1", make=lambda wanted: designs.uniform_symmetric(wanted.pitch_deg, wanted.roll_deg))
FRACTIONAL = DesignKind(
    name="fractional",
    takes=SETS | {"repeat_roll", "fractional"},
    needs={"fractional": "[K_pitch, K_roll]", "pitch_deg": ""},
    is_thinned=True,
    make=_fractional,
)
FACTORIAL = DesignKind(name="factorial", needs={}, make=_factorial)
FILE = DesignKind(name="file", takes=frozenset({"file"}), needs={"file": '"points.csv"'}, make=_file)
T = DesignKind(
    name="T", takes=frozenset(), needs={}, is_tumble=True, make=lambda wanted: designs.tumble(wanted.with_roll)
)
UP_DOWN = DesignKind(
    name="up-down",
    takes=frozenset(),
    needs={},
    is_tumble=True,
    is_on_command_line=False,
    make=lambda _wanted: designs.up_down(),
)
