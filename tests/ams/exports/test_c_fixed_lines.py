"""Straight lines and 3 by 3 matrices in fixed point: compiled, and held against the set over all of its levels."""

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from c_program import needs_compiler, printed
from changed_sets import changed
from line_sets import LEVELS_UT, line_set, triad_set
from solved_sets import gyro_set, package_set

from ams.errors import SetError, VectorsDisagree
from ams.exports.c_fixed import CHECKSUM_LINES, fixed_axes, from_c_fixed, scale_of, to_c_fixed
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, from_document

RNG = np.random.default_rng(53)
SMALL_V = {"x": (1.0 / 1.5e-4, 2.0), "y": (-1.0 / 1.4e-4, -3.0), "z": (1.0 / 1.6e-4, 0.5)}
"""µT per volt and µT: full scale of 6 mV."""
SETS = {
    "matrix": triad_set,
    "gyro": lambda: line_set({"x": (1.0443, 2.44732), "y": (0.9744, -0.561), "z": (0.9962, -0.588447)}, "dps", "dps"),
    "millivolts": lambda: line_set(SMALL_V, "ut", "v"),
    "24-bit counts": lambda: line_set(
        dict.fromkeys("xyz", (1.0 / 8e6, 0.01)), "g", "counts", levels=np.tile([-1.0, 1.0], 8)
    ),
    "one axis": lambda: line_set({"y": (0.032, -0.4)}),
}


def told(coefficients: CoefficientSet, levels: np.ndarray, folder: Path) -> dict[str, np.ndarray]:
    """Return what the compiled header says at levels, in the unit of the outputs, and let it test itself."""
    header, scale, axes = to_c_fixed(coefficients), scale_of(coefficients), list(coefficients.axes)
    words = np.rint(levels * 2.0**scale.field_bits).astype(int)
    assert np.abs(words).max() <= 2**30
    rows = ",\n".join(f"{{{x}, {y}, {z}}}" for x, y, z in words)
    calls = ", ".join(f"calrig_m1_fixed_{axis}_words(f[i])" for axis in axes)
    shown = " ".join("%d" for _ in axes)
    main = f"""
    static const int32_t f[{len(words)}][3] = {{{rows}}};
    printf("%d\\n", calrig_m1_fixed_self_test());
    for (int i = 0; i < {len(words)}; i++)
        printf("{shown}\\n", {calls});
    """
    (wrong,), *found = printed(folder, {"M1.fixed.h": header}, main)
    assert wrong == 0
    return dict(zip(axes, np.array(found).T / 2.0**scale.output_bits, strict=True))


@needs_compiler
@pytest.mark.parametrize("name", SETS)
def test_the_compiled_header_is_the_set_within_the_stated_error(name: str, tmp_path: Path) -> None:
    """Over every level that the set is valid for, to the corners of the words; exact by the set itself, in doubles."""
    coefficients = SETS[name]()
    reach = 2.0 ** (30 - scale_of(coefficients).field_bits)
    widest = max(abs(end) for limits in coefficients.validity.levels.values() for end in limits)
    assert widest <= reach < 2.0 * widest * (1.0 + 1e-9)
    corners = reach * np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    levels = np.concatenate([RNG.uniform(-reach, reach, (4000, 3)), corners])
    exact = apply(coefficients, level=levels, beyond_validity=True)
    for axis in fixed_axes(coefficients):
        found = told(coefficients, levels, tmp_path)[axis.axis]
        error = float(np.abs(found - exact[axis.axis]).max())
        assert 0.3 * axis.error < error <= axis.error
        largest = float(np.abs(exact[axis.axis]).max())
        assert axis.error < 2.0**-27 * largest * len(coefficients.axes)
        k = float(np.linalg.norm(coefficients.axes[axis.axis].direction))
        assert axis.error_of_field == pytest.approx(axis.error / k)


@pytest.mark.parametrize("name", SETS)
def test_the_whole_set_comes_back(name: str) -> None:
    coefficients = SETS[name]()
    assert from_c_fixed(to_c_fixed(coefficients), "file").sha256 == coefficients.sha256


def test_what_the_words_are_in_stands_in_the_file() -> None:
    """Levels up to 86 µT are below 128 = 2^7; |zero| + |k|·128 µT of z is 4 204 counts, below 8 192 = 2^13."""
    text = to_c_fixed(triad_set()).decode()
    assert "#define CALRIG_M1_FIXED_LEVEL_BITS 23" in text
    assert "#define CALRIG_M1_FIXED_OUTPUT_BITS 18" in text
    (stated,) = re.findall(r"^#define CALRIG_M1_FIXED_Y_ERROR_COUNTS ([-.e0-9]+)$", text, re.MULTILINE)
    assert float(stated) == fixed_axes(triad_set())[1].error
    assert "/* f in 2^-23 uT, |f| <= 2^30 each; the output in 2^-18 counts, at most" in text
    assert "Loses: rounds coefficients, levels and outputs to the bits stated in the file" in text


def scaled(factor: float) -> CoefficientSet:
    def multiply(document: dict) -> None:
        values = document["axes"]["x"]["primary"]["values"]
        values.update({name: value * factor for name, value in values.items()})

    return from_document(changed(line_set({"x": (1.0, 0.0)}, levels=LEVELS_UT), multiply), "scaled")


def test_what_does_not_fit_the_words_is_refused() -> None:
    """1 count/µT at words up to 64 µT: 2^25 times as much is 2^31 and has no room, 0.9 of that has some."""
    fits = scaled(0.9 * 2.0**25)
    assert scale_of(fits).output_bits == 0
    assert abs(fixed_axes(fits)[0].k[0]) == pytest.approx(0.9 * 2.0**31, rel=1e-9)
    with pytest.raises(SetError) as refusal:
        to_c_fixed(scaled(2.0**25))
    assert str(refusal.value) == (
        "M1: axis x: fixed point: overflow: got |zero level| + |k| up to 2147483648 counts at levels up to 64 ut, "
        "allowed below 2147483648 counts in 32 bits; nothing was written; use the floating-point header (c)"
    )


@pytest.mark.parametrize("make", [gyro_set, lambda: package_set("model")])
def test_a_set_of_another_equation_is_told_what_to_use(make: Callable[[], CoefficientSet]) -> None:
    coefficients = make()
    with pytest.raises(SetError) as refusal:
        to_c_fixed(coefficients)
    assert str(refusal.value) == (
        f"{coefficients.sensor}: C header in fixed point: has no form of this set's equations: got convention CR, "
        f"model {coefficients.model}, needed are accelerometers of pitch and roll (TP) or straight lines (SR); nothing "
        "was written; use the floating-point header (c)"
    )


def test_lines_without_a_range_of_levels_are_refused() -> None:
    def forget(document: dict) -> None:
        document["validity"] = {key: [0.0, 0.0] for key in document["validity"]}

    with pytest.raises(SetError, match="M1: fixed point: got no range of levels in the set's validity, needed is one"):
        to_c_fixed(from_document(changed(line_set({"x": (1.0, 0.0)}), forget), "set"))


def test_a_sealed_header_with_other_words_than_its_document_disagrees() -> None:
    body = CHECKSUM_LINES[-1].checked_body(to_c_fixed(triad_set()), "file")
    word = f"X_OFFSET {round(12.0 * 2**18)}".encode()
    assert word in body
    with pytest.raises(VectorsDisagree, match="file: macros and tables: the file's own are others"):
        from_c_fixed(CHECKSUM_LINES[-1].append_to(body.replace(word, word[:-1] + b"1")), "file")


def test_the_error_of_a_line_is_one_and_a_half_units_and_what_its_input_adds() -> None:
    """By hand: ½ offset, ½ k, ½ last rounding, and |k| words/2^31 of the level's half unit."""
    (axis,) = fixed_axes(SETS["one axis"]())
    units = axis.error * 2.0 ** scale_of(SETS["one axis"]()).output_bits
    assert units == pytest.approx(1.5 + abs(axis.k[1]) / 2.0**31)
    assert math.isfinite(axis.error_of_field)
