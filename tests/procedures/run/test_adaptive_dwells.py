"""Laws of ``[dwell.adaptive]``: readings by the noise of the dwells before, integrations by a trial, both on record."""

from math import ceil, sqrt
from pathlib import Path

import pytest
from small_run import QUICK_SETTLE, Bench, bench, dwells_of, measured

from procedures.check.check_report import check, to_document
from procedures.description.dwell_settings import AdaptiveDwell
from procedures.errors import PlanError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_sensors
from procedures.plan.adaptive import best_reading, samples_enough
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.resume import resume
from rig.description.read import read_rig
from rig.errors import DescriptionError

EXAMPLES = Path(__file__).parents[3] / "examples"
NOISE_V, QUIET_V, V_PER_G = 2e-5, 2e-6, 2.5
RADIANS_PER_ARCSEC = 4.84814e-6
QUIET_Y = ("azimuth_deg = -110.0, noise_v = 2e-5", "azimuth_deg = -110.0, noise_v = 2e-6")
LIMITS = "noise_arcsec = 0.5\nleast_samples = 2\nmost_samples = 40\n"


def adaptive(folder: Path, limits: str = LIMITS, begin: str = "samples = 5", *rig: tuple[str, str]) -> Bench:
    table = f"{begin}\n{QUICK_SETTLE}\n[dwell.adaptive]\n{limits}\n"
    return bench(folder, (QUIET_Y, *rig), ((f"samples = 5\n{QUICK_SETTLE}\n", table),))


def _counts(run_dir: Path, channel: str) -> list[int]:
    return [dwell.readings[channel].samples.size for dwell in dwells_of(run_dir)]


def _events(run_dir: Path, kind: str) -> list[dict]:
    with JournalReader.open(run_dir) as reader:
        return [dict(event.detail) for event in reader.events(kind)]


def test_a_dwell_ends_when_its_mean_is_known_well_enough(tmp_path: Path) -> None:
    made = adaptive(tmp_path)
    assert made.run(tmp_path / "run").state is State.FINISHED
    needed = (NOISE_V / (0.5 * RADIANS_PER_ARCSEC * V_PER_G)) ** 2
    loud, quiet = _counts(tmp_path / "run", "dmm.x"), _counts(tmp_path / "run", "dmm.y")
    assert loud[:5] == quiet[:5] == [5] * 5
    assert sum(loud[10:]) / len(loud[10:]) == pytest.approx(needed, rel=0.25)
    assert set(quiet[5:]) == {2}


def test_what_a_dwell_reads_is_on_record_before_it_is_read(tmp_path: Path) -> None:
    adaptive(tmp_path).run(tmp_path / "run")
    intended = [intent["samples"] for intent in _events(tmp_path / "run", "intent")]
    read = [
        {channel: reading.samples.size for channel, reading in dwell.readings.items()}
        for dwell in dwells_of(tmp_path / "run")
    ]
    assert intended == read


def test_the_solution_says_rule_and_choice_of_every_axis(tmp_path: Path) -> None:
    made = adaptive(tmp_path, LIMITS + "nplc = [1.0, 10.0]")
    made.run(tmp_path / "run")
    solved = solve_sensors(dwells_of(tmp_path / "run"), made.rig, made.plan, "run")["SN1"]
    (said,) = [remark for remark in solved.calibration.remarks if remark.startswith("adaptive dwells")]
    assert "known to 0.5″" in said
    assert "2 to 40 readings" in said
    assert "y 2 readings at 1 NPLC" in said
    assert "every dwell counts alike" in said


class _StopAt:
    """Asks for a stop after so many design dwells."""

    def __init__(self, run_dir: Path, dwells: int) -> None:
        self._spool, self._dwells = Spool(run_dir), dwells

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == self._dwells:
            self._spool.submit(Request("stop", "anna", "2026-03-01T12:00:00+00:00", "lunch"))


@pytest.mark.parametrize("dwells", [3, pytest.param(11, marks=pytest.mark.thorough)])
def test_a_resumed_run_reads_as_its_uninterrupted_brother(tmp_path: Path, dwells: int) -> None:
    made = adaptive(tmp_path, LIMITS + "nplc = [1.0, 2.0]")
    made.run(tmp_path / "whole")
    made.run(tmp_path / "stopped", observer=_StopAt(tmp_path / "stopped", dwells))
    assert resume(tmp_path / "stopped", "carla").state is State.FINISHED
    assert measured(dwells_of(tmp_path / "stopped")) == measured(dwells_of(tmp_path / "whole"))
    (tried,) = _events(tmp_path / "stopped", "integration")
    assert tried == _events(tmp_path / "whole", "integration")[0]


def test_check_foresees_the_duration_and_the_longest(tmp_path: Path) -> None:
    made = adaptive(tmp_path)
    made.run(tmp_path / "run")
    with JournalReader.open(tmp_path / "run") as reader:
        events = list(reader.events())
    took_s = events[-1].monotonic_s - events[0].monotonic_s
    report = to_document(check(made.rig, read_procedure(tmp_path / "procedure.toml")))
    assert report["duration_s"]["p50"] == pytest.approx(took_s, rel=0.05)
    fixed = bench(_folder(tmp_path), procedure=(("samples = 5", "samples = 40"),)).plan.expected
    assert report["duration_at_most_samples_s"]["p50"] == pytest.approx(fixed.p50_s)
    assert report["duration_at_most_samples_s"]["p50"] > report["duration_s"]["p50"]


def test_check_expects_the_noise_of_the_readings_that_it_expects(tmp_path: Path) -> None:
    report = to_document(check(adaptive(tmp_path).rig, read_procedure(tmp_path / "procedure.toml")))
    expected = report["expected_standard_uncertainty"]["SN1"]
    needed = ceil((NOISE_V / (0.5 * RADIANS_PER_ARCSEC * V_PER_G)) ** 2)
    assert expected["x"]["noise_v"] == pytest.approx(NOISE_V / sqrt(needed))
    assert expected["y"]["noise_v"] == pytest.approx(QUIET_V / sqrt(2))


def _folder(parent: Path) -> Path:
    folder = parent / "fixed"
    folder.mkdir()
    return folder


ROOM = AdaptiveDwell(noise_arcsec=1.0, least_samples=4, most_samples=100)


@pytest.mark.parametrize(
    ("noise_v", "nplc", "samples"),
    [
        ({1.0: 1.0, 10.0: 1.0}, 1.0, 4),  # both are enough at once: the shorter
        ({1.0: 10.0, 10.0: 1.0}, 10.0, 4),  # 100 readings of 1 cycle take longer than 4 of 10
        ({1.0: 4.0, 10.0: 3.9}, 1.0, 16),  # a noise that longer readings do not lower
        ({1.0: 30.0, 10.0: 20.0}, 10.0, 100),  # none is enough: the less noisy
        ({1.0: float("nan"), 10.0: 2.0}, 10.0, 4),  # overloaded at one of them
    ],
)
def test_the_integration_is_the_one_that_is_soonest_done(
    noise_v: dict[float, float], nplc: float, samples: int
) -> None:
    reading = best_reading(noise_v, lambda cycles: cycles / 50.0, 1.0, ROOM)
    assert (reading.nplc, reading.samples) == (nplc, samples)


@pytest.mark.parametrize(("noise_v", "samples"), [(0.0, 4), (2.0, 4), (3.0, 9), (3.01, 10), (10.0, 100), (1e9, 100)])
def test_as_many_readings_as_the_mean_needs_within_the_limits(noise_v: float, samples: int) -> None:
    assert samples_enough(noise_v, 1.0, ROOM) == samples


@pytest.mark.parametrize(
    ("limits", "begin", "sentence"),
    [
        ("noise_arcsec = 0.5\nleast_samples = 41\nmost_samples = 40", "samples = 40", "41 exceeds most_samples = 40"),
        (LIMITS, "samples = 50", r"samples = 50, with which adaptive dwells begin, lies outside least_samples = 2 to"),
        (LIMITS + "nplc = [1.0, 1.0]", "samples = 5", "names an integration twice"),
        (LIMITS + "nplc = [1.0, 10.0]", "samples = 5\nnplc = 1.0", "give it in one of them"),
        ("noise_arcsec = 0.5\nmost_samples = 40", "samples = 5", "least_samples"),
    ],
)
def test_limits_that_cannot_be_are_a_sentence(tmp_path: Path, limits: str, begin: str, sentence: str) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        adaptive(tmp_path, limits, begin)


DAQ = (
    ('driver = "hp3458a"', 'driver = "scpi-daq"\nmodel = "34970A"'),
    *((f"scanner = {number},", f"channel = {100 + number},") for number in (1, 2, 3)),
)


def test_an_integration_that_the_meter_does_not_offer_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"dwell\.adaptive\.nplc: readouts\.dmm cannot integrate over 1\.5 power-line"):
        adaptive(tmp_path, LIMITS + "nplc = [1.0, 1.5]", "samples = 5", *DAQ)


def test_a_burst_that_no_readout_holds_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"dwell\.adaptive\.most_samples: readouts\.dmm holds 50000 readings"):
        adaptive(tmp_path, LIMITS.replace("40", "90000"), "samples = 5", *DAQ)


def test_other_kinds_than_attitudes_at_rest_are_a_sentence(tmp_path: Path) -> None:
    example = EXAMPLES / "servo-mechanism"
    procedure = (example / "drift.toml").read_text(encoding="utf-8")
    path = tmp_path / "procedure.toml"
    path.write_text(f"{procedure}\n[dwell.adaptive]\n{LIMITS}", encoding="utf-8")
    with pytest.raises(PlanError, match=r"dwell\.adaptive: is for the attitudes of grids and tumbles, not for kind"):
        make_plan(read_rig(example / "rig.toml"), read_procedure(path))
