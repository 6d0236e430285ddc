"""A run on a machine without a home search never sends it outside limits that exclude its zero."""

from pathlib import Path

import pytest
from small_run import bench
from unattended_run import UnattendedRun, run_unattended

from procedures.records.states import State
from rig.assembly.open_rig import Rig
from rig.twins.physics.world import World

INDEXER = 'driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\nlimits_deg = [-180.0, 180.0]\n'
ROLL = f"[axes.roll]\n{INDEXER}speed_dps = 180.0\naxis = 2"
ESP301 = (
    '[axes.pitch]\ndriver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0',
    '[axes.pitch]\ndriver = "esp301"\nport = "twin"',
)
FROM_90 = (
    "roll_deg = { from = -180.0, to = 90.0, step = 90.0 }",
    "roll_deg = { from = 90.0, to = 270.0, step = 45.0 }",
)

CHECK = ("reference_every = 7", "reference_every = 7\nroll_deg = 180.0")


@pytest.mark.parametrize(
    ("driver", "dialect", "increment"),
    [
        ("indexing-table", "yaesu-gs-232", "increment_deg = 1.0"),
        ("indexing-table", "inficon-srt-422", "increment_deg = 0.18"),
        ("rate-table", "acutronic-acutrol3000", ""),
    ],
)
def test_a_run_without_a_home_search_ends_and_no_position_leaves_the_limits(
    tmp_path: Path, driver: str, dialect: str, increment: str
) -> None:
    roll = (
        f'[axes.roll]\ndriver = "{driver}"\ndialect = "{dialect}"\nport = "twin"\n{increment}\n'
        "limits_deg = [90.0, 270.0]\nspeed_dps = 20.0\narrival_tolerance_deg = 0.005\naxis = 1"
    )
    small = bench(tmp_path, rig=((ROLL, roll), ESP301), procedure=(FROM_90, CHECK))
    worlds: list[World] = []

    def seen(rig: Rig) -> Rig:
        assert isinstance(rig.chance, World)
        worlds.append(rig.chance)
        return rig

    assert run_unattended(small, UnattendedRun(tmp_path / "run"), rig_of=seen).state is State.FINISHED
    assert worlds[0].axes["roll"].reached_deg == pytest.approx((90.0, 270.0), abs=0.01)
