"""The fixed-point header: integers only, an error within the stated bound, and no overflow that is not refused."""

from pathlib import Path

import numpy as np
import pytest
from c_program import needs_compiler, printed
from changed_sets import changed
from foreign_sets import quadratic, warm
from solved import provenance, solved_package
from solved_sets import bent_set

from ams.errors import SetError, VectorsDisagree
from ams.exports.c_fixed import CHECKSUM_LINES, fixed_axes, from_c_fixed, to_c_fixed
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set, from_document

RNG = np.random.default_rng(47)


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def scaled(factor: float) -> CoefficientSet:
    """The package with every coefficient of x multiplied, its vectors left as they are."""

    def multiply(document: dict) -> None:
        values = document["axes"]["x"]["primary"]["values"]
        values.update({name: value * factor for name, value in values.items()})

    return from_document(changed(build_set(solved_package(), provenance()), multiply), "scaled")


@needs_compiler
def test_the_header_alone_reproduces_its_vectors(package: CoefficientSet, tmp_path: Path) -> None:
    main = 'printf("%d\\n", calrig_sn1047_fixed_self_test());'
    assert printed(tmp_path, {"SN1047.fixed.h": to_c_fixed(package)}, main) == [[0.0]]


@needs_compiler
def test_the_error_stays_within_the_stated_bound_and_comes_near_it(package: CoefficientSet, tmp_path: Path) -> None:
    """Exact outputs by doubles (1e-15 V) of the unrounded coefficients, at 4 000 attitudes and the six upright ones."""
    pitch, roll = np.arcsin(RNG.uniform(-1, 1, 4000)), RNG.uniform(-np.pi, np.pi, 4000)
    f = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)
    f = np.concatenate([f, np.eye(3), -np.eye(3)])
    rows = ",\n".join(f"{{{x}, {y}, {z}}}" for x, y, z in np.rint(f * 2**30).astype(int))
    main = f"""
    static const int32_t f[{len(f)}][3] = {{{rows}}};
    for (int i = 0; i < {len(f)}; i++)
        printf("%d %d %d\\n", calrig_sn1047_fixed_x_counts(f[i]), calrig_sn1047_fixed_y_counts(f[i]),
            calrig_sn1047_fixed_z_counts(f[i]));
    """
    counts = np.array(printed(tmp_path, {"SN1047.fixed.h": to_c_fixed(package)}, main))
    for axis, column in zip(fixed_axes(package), counts.T, strict=True):
        numbers = package.axes[axis.axis]
        exact_v = numbers.primary["offset_v"] + f @ numbers.direction_v_per_g
        error_v = np.abs(column / 2**26 - exact_v).max()
        assert 0.3 * axis.error < error_v <= axis.error
        assert axis.error < 2.0 / 2**26


@needs_compiler
def test_of_a_bent_sensor_it_has_the_linear_one_and_the_bound_tells_what_is_left_out(tmp_path: Path) -> None:
    """Exact outputs by the set itself, at 4 000 attitudes: beyond the bound nowhere, and near it somewhere."""
    bent = bent_set()
    pitch, roll = np.arcsin(RNG.uniform(-1, 1, 4000)), RNG.uniform(-np.pi, np.pi, 4000)
    f = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)
    words = np.rint(f * 2**30).astype(int)
    exact_v = apply(bent, pitch, roll)
    for axis in fixed_axes(bent):
        counts = np.array([axis.counts((int(x), int(y), int(z))) for x, y, z in words])
        error_v = np.abs(counts / 2**26 - exact_v[axis.axis]).max()
        assert 0.9 * axis.error < error_v <= axis.error
    header = to_c_fixed(bent)
    assert from_c_fixed(header, "bent").document == bent.document
    main = 'printf("%d\\n", calrig_sn1047_fixed_self_test());'
    assert printed(tmp_path, {"SN1047.fixed.h": header}, main) == [[0.0]]


def test_the_bound_is_stated_in_volts_and_as_an_angle(package: CoefficientSet) -> None:
    text = to_c_fixed(package).decode()
    assert f"#define CALRIG_SN1047_FIXED_X_ERROR_V {fixed_axes(package)[0].error!r}" in text
    assert "0.0024 arc seconds" in text
    assert "Loses: rounds coefficients to 2^-26 V" in text


def test_what_does_not_fit_the_words_is_refused() -> None:
    """|b| + |k| of x is 2.5353 V: twelve times as much fits into 32 V, thirteen times does not."""
    to_c_fixed(scaled(12.0))
    with pytest.raises(
        SetError, match=r"SN1047: axis x: fixed point: overflow: got .* up to 32\.9588 V, allowed below 32"
    ):
        to_c_fixed(scaled(13.0))


@pytest.mark.parametrize(("make", "terms"), [(warm, "temperature"), (quadratic, "quadratic")])
def test_terms_that_it_has_no_form_of_are_refused(make: object, terms: str) -> None:
    with pytest.raises(SetError, match=f"fixed point: got {terms} terms, allowed is v = b \\+ k.f alone; nothing was"):
        to_c_fixed(make())  # type: ignore[operator]


def test_a_sealed_header_with_other_words_than_its_document_disagrees(package: CoefficientSet) -> None:
    body = CHECKSUM_LINES[-1].checked_body(to_c_fixed(package), "file")
    with pytest.raises(VectorsDisagree, match="file: macros and tables: the file's own are others"):
        from_c_fixed(CHECKSUM_LINES[-1].append_to(body.replace(b"X_OFFSET 335544", b"X_OFFSET 335545")), "file")
