"""What is wrong with an inferred attitude, as bits of one small integer a row; words only when they are written."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ams.arrays import IntArray

Codes = NDArray[np.uint32]
AnswerCodes = NDArray[np.unsignedinteger[Any]]
"""Of an answer: the bits of the attitude, and above them those of what was done to the readings before."""

NOT_FINITE: Final = 1
BEYOND_ONE_G: Final = 2
UNSETTLED: Final = 4
PITCH_SINGULAR: Final = 8
ROLL_SINGULAR: Final = 16
SECOND_ROOT: Final = 32
NO_ROOT: Final = 64
REDUNDANCY: Final = 128
SUSPECT_X: Final = 256
SUSPECT_Y: Final = 512
SUSPECT_Z: Final = 1024
YAW_LEVEL: Final = 2048
SIDEWAYS: Final = 4096
ROLL_ON_END: Final = 8192
NO_ROLL: Final = 16384
NO_PITCH: Final = 32768
OUTSIDE_PITCH: Final = 65536
OUTSIDE_YAW: Final = 131072
OUTSIDE_TEMPERATURE: Final = 262144
RATE_BRIDGED: Final = 1 << 19
SAMPLES_LOST: Final = 1 << 20
NOT_AFTER: Final = 1 << 21
OUTSIDE_RATE: Final = 1 << 22
YAW_ASIDE: Final = 1 << 23
ADRIFT: Final = 1 << 24
AT_REST: Final = 1 << 25
ACCELERATED: Final = 1 << 26
UNAIDED: Final = 1 << 27
SUSPECT_MODEL_X: Final = 1 << 28
SUSPECT_MODEL_Y: Final = 1 << 29
SUSPECT_MODEL_Z: Final = 1 << 30
SUSPECTS: Final = (SUSPECT_X, SUSPECT_Y, SUSPECT_Z)
"""Of a package alone, or of the sting package."""
MODEL_SUSPECTS: Final = (SUSPECT_MODEL_X, SUSPECT_MODEL_Y, SUSPECT_MODEL_Z)
TWO_PACKAGES: Final = 1 << 31
"""A suspect is said with its package."""
TRANSIENT: Final = 1 << 32
FILTER_BRIDGED: Final = 1 << 33
DISAGREE: Final = 1 << 34
NOT_COMPARED: Final = 1 << 35
FIELD_UNUSED: Final = 1 << 36
OUTSIDE_ROLL: Final = 1 << 37
"""Above those of the attitude: an answer has it that a set is checked for it."""
FAULTY: Final = 1 << 38
"""The row agrees with itself, and others prove that what it was read from is wrong: a suspect is named where one is."""
FROZEN: Final = 1 << 39
STANDS: Final = (1 << 40, 1 << 41, 1 << 42)
"""An output of x, y or z lies at its zero, and nothing of a moving package is in it."""
IMPOSSIBLE_TEMPERATURE: Final = 1 << 43
WINDOW_SHORT: Final = 1 << 44
FORCE_TURNED: Final = 1 << 45
CONTRADICTED: Final = 1 << 46
NO_REST: Final = 1 << 47
OVERLOAD: Final = 1 << 48
CLIPPED: Final = 1 << 49
LOST: Final = NOT_FINITE | BEYOND_ONE_G | UNSETTLED | NO_ROOT
"""No angle at all."""

WORDS: Final[Mapping[int, str]] = {
    NOT_FINITE: "reading missing or not a number",
    BEYOND_ONE_G: "outputs beyond one g",
    UNSETTLED: "no solution: iteration did not settle",
    PITCH_SINGULAR | ROLL_SINGULAR: "pitch and roll singular",
    PITCH_SINGULAR: "pitch singular",
    ROLL_SINGULAR: "roll singular",
    SECOND_ROOT: "second attitude: within the coning angle of the vertical",
    NO_ROOT: "no attitude on the side asked for",
    SIDEWAYS: "sign of pitch and yaw undetermined: yaw near ±90°",
    YAW_LEVEL: "yaw singular: pitch near zero",
    ROLL_ON_END: "roll singular: sting axis near vertical",
    NO_PITCH: "no pitch gives this output",
    REDUNDANCY: "redundancy: outputs disagree",
    FAULTY: "redundancy: outputs in doubt by other rows",
    NOT_AFTER: "time is not after the row before: not used",
    SAMPLES_LOST: "samples missing before this row",
    RATE_BRIDGED: "rate missing: bridged",
    AT_REST: "at rest: attitude of the start",
    NO_REST: "start: it did not rest",
    YAW_ASIDE: "pitch and roll singular: yaw near ±90°",
    ADRIFT: "attitude unknown: grown uncertain",
    ACCELERATED: "force not used: package accelerates",
    UNAIDED: "gravity not seen for too long",
    OUTSIDE_RATE: "rate outside the validity of the set",
    NO_ROLL: "roll not sensed: sting package alone",
    OUTSIDE_PITCH: "pitch outside the validity of the set",
    OUTSIDE_ROLL: "roll outside the validity of the set",
    OUTSIDE_YAW: "yaw outside the validity of the set",
    OUTSIDE_TEMPERATURE: "temperature outside the validity of the set",
}
"""In the order in which they are said."""


FILTER_WORDS: Final[Mapping[int, str]] = {
    FILTER_BRIDGED: "reading missing: bridged by the filter",
    TRANSIENT: "filter not settled",
}
WINDOW_WORDS: Final[Mapping[int, str]] = {
    NOT_FINITE: "reading missing or not a number: nothing of the window is left",
    WINDOW_SHORT: "readings missing in the window: mean of those left",
}
FROZEN_WORDS: Final[Mapping[int, str]] = {
    FROZEN: "output frozen: taken as missing",
}
CLIPPED_WORDS: Final[Mapping[int, str]] = {
    CLIPPED: "output clipped at a rail: taken as missing",
}
OVERLOAD_WORDS: Final[Mapping[int, str]] = {
    OVERLOAD: "overload: taken as missing",
}
TEMPERATURE_WORDS: Final[Mapping[int, str]] = {
    IMPOSSIBLE_TEMPERATURE: "temperature that no sensor stands: taken as missing",
}
STANDING_WORDS: Final[Mapping[int, str]] = {
    code: f"{axis} lies at its zero though the package moves" for axis, code in zip("xyz", STANDS, strict=True)
}
GRAVITY_WORDS: Final[Mapping[int, str]] = {
    FORCE_TURNED: "force not used: a zero of the gyros is not as stated, or the package accelerates",
    CONTRADICTED: "gravity contradicts the gyros: a zero is not as stated, or the package accelerates",
}
FIELD_WORDS: Final[Mapping[int, str]] = {
    FIELD_UNUSED: "field not used: disturbed",
}
MONITOR_WORDS: Final[Mapping[int, str]] = {
    DISAGREE: "accelerometers and gyros disagree",
    NOT_COMPARED: "not compared with the gyros",
}
ONE_AXIS_WORDS: Final[Mapping[int, str]] = {
    **WORDS,
    BEYOND_ONE_G: "output beyond one g",
    PITCH_SINGULAR: "pitch singular: sensor axis vertical",
}


def words(codes: AnswerCodes, reasons: Mapping[int, str] = WORDS) -> tuple[str, ...]:
    """Return the flag of every row, empty where all is well; several reasons are parted by a semicolon."""
    said, indices = distinct_words(codes, reasons)
    return tuple(said[index] for index in indices.tolist())


def distinct_words(codes: AnswerCodes, reasons: Mapping[int, str] = WORDS) -> tuple[list[str], IntArray]:
    """Return the flags that there are, each once, and the place among them of every row's."""
    indices = np.zeros(codes.size, dtype=np.int64)
    rows = np.flatnonzero(codes)
    distinct, distinct_of = np.unique(codes[rows], return_inverse=True)
    indices[rows] = distinct_of + 1
    return ["", *(_said(int(code), reasons) for code in distinct)], indices


def _said(code: int, words_of: Mapping[int, str]) -> str:
    suspects = _suspects(code)
    reasons = []
    for bits, reason in words_of.items():
        if code & bits == bits:
            if suspects and bits == REDUNDANCY:
                reason = f"redundancy: suspect {suspects}"
            elif suspects and bits == FAULTY:
                reason = f"redundancy: {suspects} proven wrong by other rows"
            reasons.append(reason)
            code &= ~bits
    return "; ".join(reasons)


def _suspects(code: int) -> str:
    """Return ``y``, or with two packages ``y or z of the model package``."""
    is_suspect = [bool(code & bit) for bit in (*SUSPECTS, *MODEL_SUSPECTS)]
    if code & TWO_PACKAGES:
        return suspects_in_words(is_suspect, "xyzxyz", ["sting"] * 3 + ["model"] * 3)
    return ", ".join(axis for axis, there in zip("xyz", is_suspect[:3], strict=True) if there)


def suspects_in_words(is_suspect: Sequence[bool], axes: Sequence[str], packages: Sequence[str]) -> str:
    """Return "y or z of the model package" for readings that are suspect, by their axes and packages."""
    parts = []
    for package in dict.fromkeys(packages):
        suspected = [
            axis for axis, of, there in zip(axes, packages, is_suspect, strict=True) if there and of == package
        ]
        if suspected:
            parts.append(f"{' or '.join(suspected)} of the {package} package")
    return " or ".join(parts)
