"""Every benchmark runs, as `make bench` calls it but at its smallest; only ratios to peers may fail it."""

import math
from collections.abc import Iterator

import pytest

import bench.__main__
from bench.__main__ import BENCHMARKS, figures_of, main
from bench.figure import Effort, Figure

PEERS = {
    "fit": ["curve_fit", "lmfit", "row by row"],
    "report": ["pyplot, as many"],
    "attitude": ["Butcher's method", "scipy's rotations", "solve_ivp"],
}


SHORT = ("fit", "attitude", "engine")
"""Tried with every change; CI tries the others."""
SLOW = ("rehearsal",)
"""A whole night in virtual time, however small: with the long proofs."""


def _marks(name: str) -> tuple[pytest.MarkDecorator, ...]:
    return () if name in SHORT else (pytest.mark.soak,) if name in SLOW else (pytest.mark.thorough,)


@pytest.mark.parametrize("name", [pytest.param(name, marks=_marks(name)) for name in BENCHMARKS])
def test_a_benchmark_runs_and_every_figure_is_a_number_beside_its_target(name: str) -> None:
    found = list(figures_of([name], Effort(is_tiny=True)))
    assert found
    for figure in found:
        assert math.isfinite(figure.value), figure
        assert figure.value >= 0.0, figure
        assert figure.target >= 0.0, figure
    peers = [entry.what.split("/")[0].strip() for entry in found if entry.is_gated]
    assert [peer for peer in peers if not peer.startswith("ahrs ")] == PEERS.get(name, [])  # where it is installed


@pytest.mark.parametrize(
    ("value", "is_gated", "status", "verdict"),
    [(6.0, True, 0, ""), (4.0, True, 1, "FAILED"), (4.0, False, 0, "MISSED")],
    ids=["within", "a peer is faster", "a busy machine"],
)
def test_a_ratio_to_a_peer_out_of_its_bound_fails_and_a_missed_time_does_not(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    value: float,
    is_gated: bool,
    status: int,
    verdict: str,
) -> None:
    def figures(names: object, effort: Effort) -> Iterator[Figure]:
        yield Figure("peer / ours", value, "×", 5.0, at_most=False, is_gated=is_gated)

    monkeypatch.setattr(bench.__main__, "figures_of", figures)
    assert main([]) == status
    found = capsys.readouterr()
    assert verdict in found.out
    assert ("peer / ours" in found.err) == bool(status)


def test_a_name_of_no_benchmark_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["speed"])
    assert "no benchmark speed (allowed: fit, engine" in capsys.readouterr().err
