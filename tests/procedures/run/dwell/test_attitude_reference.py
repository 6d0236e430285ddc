"""An inclinometer on a head with bad teeth: what it tells is the attitude of every dwell, and where it ends so does the
run.
"""

from pathlib import Path

import pytest
from example_files import ROOT
from small_run import Bench, bench, dwells_of

from procedures.solution.type_b import standard_uncertainty_arcsec, table_in_words
from rig.assembly.prove import prove
from rig.description.read import read_rig
from rig.twins.physics.world import World

DIALECT = ROOT / "examples" / "inclinometer" / "full-circle.toml"
WITH_ONE = (
    "[environment.air]",
    """[readouts.level]
driver = "angle-meter"
resource = "twin"
dialect = "{dialect}"
channels = {{ tilt = {{ about = "pitch", sign = -1, zero_deg = 0.25, range_deg = {range_deg} }} }}
[attitude_reference]
channels = {{ pitch = "level.tilt" }}
uncertainty_deg = 0.0008
samples = 3
[environment.air]""",
)
BAD_TEETH = ("[twin.truth.SN1]", "[twin.axes.pitch]\nindex_error_arcsec = 60.0\n[twin.truth.SN1]")


def _bench(folder: Path, range_deg: float = 45.0) -> Bench:
    old, new = WITH_ONE
    return bench(
        folder,
        rig=((old, new.format(dialect=DIALECT, range_deg=range_deg)), BAD_TEETH),
        procedure=(("replications = 2", "replications = 1"),),
    )


def test_every_dwell_has_the_attitude_that_the_inclinometer_tells(tmp_path: Path) -> None:
    small = _bench(tmp_path)
    outcome = small.run(tmp_path / "run")
    assert outcome.state == "finished", outcome
    world, off_deg = World(small.rig), set[float]()
    for dwell in dwells_of(tmp_path / "run"):
        world.rotate("pitch", dwell.targets_deg["pitch"], 0.0)
        true_deg = world.attitude_deg("pitch", 1e6)
        assert dwell.measured_deg["pitch"] == pytest.approx(true_deg, abs=6e-5), "four decimals on the wire"
        assert dwell.measured_deg["roll"] == dwell.targets_deg["roll"]
        off_deg.add(round(3600.0 * (dwell.measured_deg["pitch"] - dwell.targets_deg["pitch"]), 1))
    assert len(off_deg) >= 3
    assert max(map(abs, off_deg)) > 5.0, "the table alone would have been believed"


def test_its_uncertainty_stands_in_the_budget_in_place_of_the_axis_s(tmp_path: Path) -> None:
    rig = _bench(tmp_path).rig
    assert standard_uncertainty_arcsec(rig, "pitch") == pytest.approx(2.88)
    assert "pitch u 2.9″ by level.tilt" in table_in_words(rig)


def test_an_attitude_beyond_its_range_is_none(tmp_path: Path) -> None:
    outcome = _bench(tmp_path, range_deg=20.0).run(tmp_path / "run")
    assert outcome.state == "tripped"
    assert "level.tilt is beyond its range: the attitude is not known" in str(outcome)


def test_the_example_s_devices_are_as_their_twins(tmp_path: Path) -> None:
    proofs = prove(read_rig(ROOT / "examples" / "inclinometer" / "rig.toml"), tmp_path)
    assert "readouts.level" in {proof.key for proof in proofs}
    assert [difference for proof in proofs for difference in proof.differences] == []
