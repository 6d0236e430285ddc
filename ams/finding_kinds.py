"""Every kind of finding in one table: whose doing it is, what it means, and what a laboratory does about it.

A new kind is a name in the list and a row in the table; whoever asks of a kind (whether as found stands, whether an
axis has a result, whether the meter changed) asks here, and the page of all kinds is made from it.
"""

from collections.abc import Mapping
from typing import Final, Literal, NamedTuple, get_args

FindingKind = Literal[
    "wrong-dwell",
    "lack-of-fit",
    "quadratic",
    "cubic",
    "asymmetry",
    "cross-coupling",
    "drift",
    "autocorrelation",
    "temperature-residual",
    "temperature-lag",
    "temperature-curvature",
    "table-rotation",
    "meter-gain",
    "meter-offset",
    "sensor-change",
    "level-undeclared",
    "table-undeclared",
    "meter-undeclared",
    "rate-undeclared",
    "gravity-undeclared",
    "field-undeclared",
    "time-confounded",
    "axis-undetermined",
    "axis-contradicted",
    "field-contradicted",
    "output-clipped",
    "uneven-noise",
    "record-lost",
]
Whose = Literal["sensor", "table", "meter", "run", "file"]
"""``sensor``: its own, which its users had as well, where no single test says otherwise; ``table``: also its base or
the common fixture; ``meter``: also what all sensors share; ``run``: how it was measured, or what is declared of it
against what was read, where nothing says which is wrong; ``file``: what nobody declared."""
FINDING_KINDS: Final[tuple[str, ...]] = get_args(FindingKind)


class KindOfFinding(NamedTuple):
    """What holds of every finding of a kind."""

    whose: Whose
    meaning: str
    """In one sentence, without its stop."""
    what_to_do: str
    """By the laboratory; a finding itself may say more, with its commands and steps."""
    together: str = ""
    """Whose doing it is in words, where all sensors of a check set show it; empty of a kind that they do not show."""
    leaves_no_result: bool = False
    """Whether an axis with a significant one has no result to use and no set."""


_TAKE_THE_TERM_IN: Final = (
    "Take the term into the solution where the points determine it (`[solve] extended`, `--extended`), or accept it "
    "where it is small against what is asked of the sensor"
)
_DECLARE: Final = (
    "Declare it with the key that the finding names and solve again; a certificate says, or asks for, what is missing"
)

KINDS: Final[Mapping[FindingKind, KindOfFinding]] = {
    "wrong-dwell": KindOfFinding(
        "run",
        "Dwells read otherwise than their point does in the other replications: not at rest, at another attitude, or "
        "mistyped",
        "Look at the steps named; `calrig void` takes them back and measures them again, of a file take the rows out",
    ),
    "lack-of-fit": KindOfFinding(
        "sensor",
        "The model does not describe the points as well as they repeat; some tests of this kind name the table (its "
        "declared limit, the squareness of its axes) and are the table's, and one names the index or the attitude at "
        "which alone an output is off",
        "Look at the residuals over the attitudes: take further terms in, or declare the errors of the table",
    ),
    "quadratic": KindOfFinding(
        "sensor", "The output bends with the square of what the axis senses (K₂, or K_pp − K_oo)", _TAKE_THE_TERM_IN
    ),
    "cubic": KindOfFinding(
        "sensor", "The output bends with the third power of what the axis senses (K₃)", _TAKE_THE_TERM_IN
    ),
    "asymmetry": KindOfFinding(
        "sensor",
        "Offset or sensitivity differ between the two directions of the axis (K₀′, K₁′)",
        "No term of the result has it: accept it where it is small against what is asked of the sensor, or have the "
        "sensor looked at",
    ),
    "cross-coupling": KindOfFinding(
        "sensor", "The output holds a product of what two axes sense (K_ip, K_io, K_po)", _TAKE_THE_TERM_IN
    ),
    "drift": KindOfFinding(
        "sensor",
        "The output changed with time, or replications differ by more than their scatter; settling at the start of "
        "replications is the run's",
        "Let everything warm up for longer; take an even drift into the solution (`[solve] time_term`), or measure the "
        "replication that differs again",
    ),
    "autocorrelation": KindOfFinding(
        "sensor",
        "A reading keeps something of the dwells or the channel before it, or dwells beside each other are alike",
        "Dwell for longer or wait longer before reading; measure replications in different orders",
    ),
    "temperature-residual": KindOfFinding(
        "sensor",
        "The output follows the recorded temperature, or that goes with the attitudes, and no temperature is modelled",
        "Hold the temperature, take another order of the points, or apply known temperature coefficients",
    ),
    "temperature-lag": KindOfFinding(
        "run",
        "The output follows the thermometer later, so that sensor and thermometer were not at one temperature",
        "Soak for longer, or measure the temperature in the sensor",
    ),
    "temperature-curvature": KindOfFinding(
        "sensor",
        "The output, or a term of it, is no straight line over temperature",
        "Solve with terms of second order (`[solve] temperature_order = 2`), or calibrate at the temperature of use",
    ),
    "table-rotation": KindOfFinding(
        "table",
        "The table, its base or the common fixture turned while it was measured, stood off all the while, or comes to "
        "rest by the way that it came (backlash)",
        "Look at coupling, base and fixture; measure again what stands behind the turn, of an axis with backlash with "
        "an approach from one side, or release by name what was put in quarantine",
        together="the table, its base or the common fixture",
    ),
    "meter-gain": KindOfFinding(
        "meter",
        "All outputs changed in proportion: the gain of the meter, or what all sensors share",
        "Have the meter proved against its references; `calrig void` measures the dwells in doubt again",
        together="the gain of the meter, or what all sensors share",
    ),
    "meter-offset": KindOfFinding(
        "meter",
        "All outputs changed by the same: the offset of the meter, or what all sensors share",
        "Have the meter proved with its inputs shorted; `calrig void` measures the dwells in doubt again",
        together="the offset of the meter, or what all sensors share",
    ),
    "sensor-change": KindOfFinding(
        "sensor",
        "One sensor or one of its axes changed while the others did not: itself, its mount or its channel",
        "Look at mount and connector, and measure that sensor again; if it changes again it is the sensor",
    ),
    "level-undeclared": KindOfFinding(
        "file",
        "Nobody read a level, so that gravity's direction against the table is in no uncertainty",
        _DECLARE,
    ),
    "table-undeclared": KindOfFinding(
        "file",
        "Nothing is declared of the indices, or of gyros the directions, of the axes that turned, so that their errors "
        "are in no uncertainty",
        _DECLARE,
    ),
    "meter-undeclared": KindOfFinding(
        "file",
        "No standard of the meter, or no crosstalk of its scanner, is declared, so that their errors are in no "
        "uncertainty",
        _DECLARE,
    ),
    "rate-undeclared": KindOfFinding(
        "file",
        "No standard of the rates is declared, so that their errors are in no uncertainty; or, where it is a "
        "reservation, the rates lack the Earth's, which the readings show",
        _DECLARE,
    ),
    "gravity-undeclared": KindOfFinding(
        "file",
        "No uncertainty of local gravity is declared: what is told per m/s² or at another gravity is without it",
        _DECLARE,
    ),
    "field-undeclared": KindOfFinding(
        "file",
        "Nothing is declared of how far the field of a coil may be wrong, its direction, or what stands beside it, so "
        "that their errors are in no uncertainty",
        _DECLARE,
    ),
    "time-confounded": KindOfFinding(
        "sensor",
        "Time goes with attitude inside the replications, or inside every laying, so that a drift passes for offset "
        "and sensitivity",
        "Measure every replication to its end, in an order such as there-and-back (of levels forward-reverse), or "
        "solve with an even drift",
    ),
    "axis-undetermined": KindOfFinding(
        "run",
        "The sensitivity of the nominal axis is not told from zero by the attitudes visited, or its offset is not "
        "known to within what the output changes by over 1 g",
        "Add attitudes that change what the axis senses, correct what is declared, or leave the axis out",
        leaves_no_result=True,
    ),
    "axis-contradicted": KindOfFinding(
        "run",
        "The readings are not those of what is declared: another axis, polarity, sign or order of angles, a "
        "sensitivity far from the declared one, or in one replication another output or the dwell beside",
        "Correct the file, the rig file or the wiring, and solve or measure again",
        leaves_no_result=True,
    ),
    "field-contradicted": KindOfFinding(
        "run",
        "The axes of a magnetometer do not agree on the field that each was solved in",
        "Measure the surroundings with the coil off, look for iron, and correct what is declared of field and coil",
    ),
    "output-clipped": KindOfFinding(
        "run",
        "Dwells stand at a rail of the amplifier or the meter, equal to the last digit",
        "Widen the range or lower the gain, and measure again",
        leaves_no_result=True,
    ),
    "uneven-noise": KindOfFinding(
        "run",
        "Some replications scatter plainly more than the others",
        "Look for what was switched or shaken meanwhile, and measure those replications again",
    ),
    "record-lost": KindOfFinding(
        "run",
        "The journal was damaged and salvaged; where lines of its audit trail are lost, what they took back may count "
        "again",
        "Ask who ran it what was taken back, and measure the run again, or release by name what was put in quarantine",
    ),
}


def kinds_of(*whose: Whose) -> frozenset[FindingKind]:
    """Return the kinds that are the doing of one of these."""
    return frozenset(kind for kind, row in KINDS.items() if row.whose in whose)


UNUSABLE_AXIS: Final = frozenset(kind for kind, row in KINDS.items() if row.leaves_no_result)
"""Of an axis with such a finding, where it is significant, there is no result to use and no set."""
OF_THE_TABLE: Final = kinds_of("table")
OF_THE_METER: Final = kinds_of("meter")
"""Also of what moves the axes of one name in all sensors alike."""
