"""What a recorded temperature explains as well as anything that is only imagined is told as the temperature's.

The room swings once in every replication, and one axis alone, that senses pitch, sees it go there and back meanwhile:
what the temperature does has nearly the form of a memory of ten dwells, or of a bend.
"""

import numpy as np
from physics_scenes import campaigns, mixed
from solved_campaigns import findings_of_lone_x

from ams.findings import Finding

COUNT = 30


def by_point(findings: list[Finding]) -> list[Finding]:
    return [said for said in findings if str(said.details.get("test")).startswith("temperature, point by point")]


def test_a_temperature_in_step_with_the_replications_is_no_memory_and_no_bend() -> None:
    found = findings_of_lone_x(campaigns("temperature-in-step", 0.1, np.random.default_rng(20), COUNT), COUNT)
    imagined = [any(said.kind in ("autocorrelation", "quadratic") for said in each) for each in found]
    assert sum(imagined) <= 3  # in six of ten where the most significant column went first
    assert sum(bool(by_point(each)) for each in found) >= COUNT - 2


def test_a_bend_that_the_temperature_explains_as_well_is_named_beside_it() -> None:
    found = findings_of_lone_x(
        mixed({"k2": 10.0, "temperature-in-step": 0.02}, np.random.default_rng(20), COUNT), COUNT
    )
    bends = [any("K₂" in said.text for said in each) for each in found]
    assert sum(bends) >= COUNT - 2
    either = [said.text for each in found for said in by_point(each) if "K₂ fits these points as well" in said.text]
    assert either, "in no campaign the temperature goes with pitch"
