"""Copies are refused; readings that repeat because a meter is coarse, or nothing scatters, are not."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.errors import ObservationsError
from ams.inputs.copied_replications import refuse_copies
from ams.observations import Observations


def _rows(noise_arcsec: float = 1.65, seed: int = 2, **design: float) -> Observations:
    drawn = campaigns("use-good", 0.0, np.random.default_rng(seed), 1, noise_arcsec=noise_arcsec, **design).calibration
    return replace(rows_of(drawn), outputs={axis: columns_of(drawn, axis)[:, 0] for axis in "xyz"})


def _copied(rows: Observations, onto: tuple[int, ...], of: int = 1, kept: int = 0) -> Observations:
    """Return the rows with some replications overwritten by another, but for the first points of each."""
    first, *_ = labels = np.unique(rows.replication)
    source = labels[of - 1] if of > 1 else first
    outputs = {axis: values.copy() for axis, values in rows.outputs.items()}
    for label in onto:
        for values in outputs.values():
            where = np.flatnonzero(rows.replication == labels[label - 1])[kept:]
            values[where] = values[np.flatnonzero(rows.replication == source)[kept:]]
    return replace(rows, outputs=outputs)


@pytest.mark.parametrize(("onto", "of"), [((2,), 1), ((2, 3, 4, 5, 6), 1), ((5,), 3)])
def test_copies_are_refused_by_name(onto: tuple[int, ...], of: int) -> None:
    rows = _rows()
    labels = np.unique(rows.replication)
    with pytest.raises(ObservationsError) as refused:
        refuse_copies(_copied(rows, onto, of))
    assert f"{', '.join(str(labels[label - 1]) for label in onto)} " in str(refused.value)
    assert f"of replication {labels[of - 1]}:" in str(refused.value)
    assert "156 of 156 points" in str(refused.value)


def test_a_copy_of_which_a_few_points_were_measured_again_is_refused() -> None:
    with pytest.raises(ObservationsError, match="146 of 156 points"):
        refuse_copies(_copied(_rows(), (4,), kept=10))


@pytest.mark.parametrize("step_v", [0.0, 1e-5, 2e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("noise_arcsec", [0.0, 0.02, 0.2, 1.65])
def test_measured_replications_are_none(step_v: float, noise_arcsec: float) -> None:
    for limit in (30.0, 90.0):
        rows = _rows(noise_arcsec, pitch_limit_deg=limit)
        if step_v:
            rows = replace(rows, outputs={a: np.rint(v / step_v) * step_v for a, v in rows.outputs.items()})
        refuse_copies(rows)


@pytest.mark.parametrize("digits", [6, 9, 12])
def test_exact_outputs_of_a_file_with_few_digits_are_none(digits: int) -> None:
    rows = _rows(0.0)
    refuse_copies(replace(rows, outputs={axis: values.round(digits) for axis, values in rows.outputs.items()}))


def test_an_axis_that_stands_still_makes_no_copies() -> None:
    rows = _rows()
    refuse_copies(replace(rows, outputs={**rows.outputs, "z": np.full(rows.rows, 0.3)}))
