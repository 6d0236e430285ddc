"""Random fault scripts over a small campaign in virtual time, on four sets of devices: no finished run has a parameter
that is off without a word, nothing is ever sent outside its limits, nothing moves after the end of a run."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from device_sets import RIGS, SHORTER, device_set
from fault_scripts import Parameters, Story, parameters_of, random_script, tell_of, worst_deviation
from small_run import Bench, measured_in

from procedures.delivery.deliver import sensors_document, solve_run
from procedures.records.states import State
from rig.description.fault_plan import FaultPlan

MOST_U = 4.0
DURATION_S = 60.0
"""Of the campaign, rig seconds: when things go wrong at a moment, it is within them."""
LONG = """
[procedure]
title = "2 886 dwells"
kind = "grid"
replications = 6
[design]
kind = "D"
pitch_deg = { from = -90.0, to = 90.0, step = 5.0 }
roll_deg = { from = -180.0, to = 180.0, step = 30.0 }
[dwell]
samples = 8
settle = { window_s = 0.5, windows = 2, min_s = 0.5, max_s = 30.0 }
retries = 3
"""


@dataclass(frozen=True)
class Campaign:
    bench: Bench
    clean: Parameters

    @staticmethod
    def of(bench: Bench) -> "Campaign":
        assert bench.run(bench.folder / "clean").state is State.FINISHED
        return Campaign(bench, parameters_of(sensors_document(solve_run(bench.folder / "clean"))))


MakeCampaign = Callable[[str], Campaign]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> MakeCampaign:
    made: dict[str, Campaign] = {}

    def make(devices: str) -> Campaign:
        if devices not in made:
            made[devices] = Campaign.of(device_set(devices, tmp_path_factory.mktemp(devices), SHORTER))
        return made[devices]

    return make


def _judge(story: Story, clean: Parameters) -> None:
    """The oracle's verdict on one run."""
    if story.is_finished and not story.is_flagged:
        worst = worst_deviation(story, clean)
        assert worst <= MOST_U, f"silently off by {worst:.3g} standard uncertainties: {story.plan!r}: {story.happened}"


def _try(campaign: Campaign, folder: Path, seeds: range) -> Counter[str]:
    found: Counter[str] = Counter()
    for seed in seeds:
        plan = random_script(campaign.bench, seed, DURATION_S)
        try:
            story = tell_of(campaign.bench, folder / f"run-{seed}", plan)
            _judge(story, campaign.clean)
        except BaseException as error:
            error.add_note(f"script of seed {seed}: {plan!r}")
            raise
        found[story.outcome.state if story.outcome else "unopened"] += 1
        found["struck"] += bool(story.happened)
    return found


@pytest.mark.parametrize(
    "seeds",
    [range(2), pytest.param(range(2, 12), marks=pytest.mark.thorough), pytest.param(range(75), marks=pytest.mark.soak)],
    ids=str,
)
@pytest.mark.parametrize("devices", RIGS)
@pytest.mark.timeout(600)
def test_random_fault_scripts_leave_no_wrong_parameter_without_a_word(
    campaign: MakeCampaign, tmp_path: Path, devices: str, seeds: range
) -> None:
    """Three for each of the four sets of devices; 75 each among the soaks, and three thousand others."""
    found = _try(campaign(devices), tmp_path, seeds)
    assert found["struck"] >= 0.75 * len(seeds), "most scripts do happen"
    assert found[State.FINISHED] >= 0.75 * len(seeds), "most faults heal"


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("devices", RIGS)
def test_three_thousand_random_fault_scripts_leave_no_wrong_parameter_without_a_word(
    campaign: MakeCampaign, tmp_path: Path, devices: str
) -> None:
    found = _try(campaign(devices), tmp_path, range(1000, 1750))
    assert found[State.FINISHED] > 600


def test_the_oracle_sees_one_parameter_that_is_off_and_believes_a_run_that_says_so(
    campaign: MakeCampaign, tmp_path: Path
) -> None:
    """The harness itself: one value of a clean run moved by five of its standard uncertainties."""
    known = campaign("table-3458a")
    story = tell_of(known.bench, tmp_path / "run", _one_percent("duplicate"))
    _judge(story, known.clean)
    value, uncertainty = known.clean[("y", "coning_deg")]
    story.parameters = {**known.clean, ("y", "coning_deg"): (value + 5.0 * uncertainty, uncertainty)}
    with pytest.raises(AssertionError, match="silently off by 5 standard uncertainties"):
        _judge(story, known.clean)
    story.trips = 1
    _judge(story, known.clean)


KINDS = ("drop", "truncate", "garble")
"""Of damage; each set of devices meets one of them in every change, and CI all."""


@pytest.mark.parametrize(
    ("devices", "kind"),
    [
        pytest.param(devices, kind, marks=() if index % len(KINDS) == rank else pytest.mark.thorough)
        for index, devices in enumerate(RIGS)
        for rank, kind in enumerate(KINDS)
    ],
)
def test_fault_37_one_reply_in_a_hundred_damaged_detectably_changes_no_number(
    campaign: MakeCampaign, tmp_path: Path, devices: str, kind: str
) -> None:
    known = campaign(devices)
    story = tell_of(known.bench, tmp_path / "run", _one_percent(kind))
    assert len(story.happened) > 5
    assert story.is_finished
    assert measured_in(story.run_dir) == measured_in(known.bench.folder / "clean")
    assert story.parameters == known.clean


@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 3), marks=pytest.mark.thorough)], ids=str)
@pytest.mark.parametrize("devices", RIGS)
def test_fault_24_one_reply_in_a_hundred_with_a_flipped_bit_is_noticed_or_harmless(
    campaign: MakeCampaign, tmp_path: Path, devices: str, seeds: range
) -> None:
    known = campaign(devices)
    for seed in seeds:
        story = tell_of(known.bench, tmp_path / f"run-{seed}", _one_percent("flip-bit", seed))
        assert story.happened
        _judge(story, known.clean)


@pytest.mark.parametrize("devices", RIGS)
def test_fault_24_questions_that_the_line_damages_are_refused_by_the_devices_and_asked_again(
    campaign: MakeCampaign, tmp_path: Path, devices: str
) -> None:
    """What a meter, a scanner or a data-acquisition unit calls a syntax error voids the attempt, not the run."""
    known = campaign(devices)
    rule = {
        "line": "readouts.dmm",
        "kind": "flip-bit",
        "byte": 1,
        "bit": 0,
        "on": "question",
        "nth": (150, 300, 450, 600),
    }
    story = tell_of(known.bench, tmp_path / "run", FaultPlan.model_validate({"fault": {"flip": rule}}))
    assert len(story.happened) >= 3
    assert story.is_finished
    assert measured_in(story.run_dir) == measured_in(known.bench.folder / "clean")


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_fault_37_a_campaign_of_2886_dwells_ends_with_the_same_coefficients_though_one_reply_in_a_hundred_is_damaged(
    tmp_path: Path,
) -> None:
    known = Campaign.of(device_set("table-3458a", tmp_path, LONG))
    assert len(known.bench.plan.design_dwells) == 2886
    story = tell_of(known.bench, tmp_path / "damaged", _one_percent("garble"))
    assert story.is_finished
    assert len(story.happened) > 2000
    assert story.parameters == known.clean
    flipped = tell_of(known.bench, tmp_path / "flipped", _one_percent("flip-bit"), most_resumes=200)
    assert flipped.is_finished
    worst = worst_deviation(flipped, known.clean)
    assert worst <= 0.1 or (worst <= MOST_U and flipped.is_flagged), f"off by {worst:.3g} standard uncertainties"


def _one_percent(kind: str, seed: int = 0) -> FaultPlan:
    """Of all replies on all lines."""
    rule: dict[str, object] = {"line": "*", "kind": kind, "probability": 0.01}
    if kind == "truncate":
        rule["keep"] = 3
    return FaultPlan.model_validate({"seed": seed, "fault": {"damage": rule}})
