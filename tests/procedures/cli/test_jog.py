"""Laws of jogging by command: the limits of the rig hold, the machine must be homed, and a refusal moves nothing."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from command import call
from job_files import job, simulated


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A rig file whose devices answer on real ports, in another process, much faster than real time."""
    folder = tmp_path_factory.mktemp("bench")
    _, rig = job(folder, None, {"limits_deg = [-180.0, 180.0]": "limits_deg = [-90.0, 90.0]"})
    with simulated(rig, folder / "ports.toml", "--time-factor", "200"):
        yield folder / "ports.toml"


def test_a_machine_that_is_not_homed_does_not_move(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "jog", "--rig", bench, "--axis", "roll", "--to", 10, "--json")
    assert (outcome.status, outcome.out) == (2, "")
    assert "roll: the axis is not homed" in outcome.err


def test_absolute_and_relative_moves_end_at_rest_where_they_were_sent(
    bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(capsys, "jog", "--rig", bench, "--axis", "pitch", "--home").status == 0
    assert call(capsys, "jog", "--rig", bench, "--axis", "pitch", "--to", 10, "--json").document["position_deg"] == 10.0
    assert (
        call(capsys, "jog", "--rig", bench, "--axis", "pitch", "--by", -25, "--json").document["position_deg"] == -15.0
    )


REFUSALS = [
    (("--axis", "pitch", "--to", 91), "90"),
    (("--axis", "pitch", "--to", 10.5), "multiples of 1 deg"),
    (("--axis", "pitch", "--to", "nan"), "nan"),
    (("--axis", "yaw", "--to", 1), "no axis 'yaw' (allowed: pitch, roll)"),
    (("--axis", "pitch", "--to", 1, "--by", 1), "--to and --by together are unclear"),
    (("--to", 1), "--to needs --axis"),
    (("--axis", "pitch"), "--axis needs --to, --by, --rate, --home or --stop"),
    (("--live", "--json"), "--live"),
    (("--samples", 1), "--samples: got 1"),
]


@pytest.mark.parametrize(("options", "sentence"), REFUSALS, ids=[" ".join(map(str, r[0])) for r in REFUSALS])
def test_a_refusal_is_a_sentence_and_moves_nothing(
    bench: Path, capsys: pytest.CaptureFixture[str], options: tuple[object, ...], sentence: str
) -> None:
    call(capsys, "jog", "--rig", bench, "--axis", "pitch", "--home")
    before = call(capsys, "jog", "--rig", bench, "--samples", 2, "--json").document["positions_deg"]
    outcome = call(capsys, "jog", "--rig", bench, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err
    assert call(capsys, "jog", "--rig", bench, "--samples", 2, "--json").document["positions_deg"] == before


def test_roll_right_wing_down_makes_the_y_output_negative(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """DESIGN 5: +pitch gives +S on x, level gives −S on z, roll +90° gives −S on y."""
    _, rig = job(tmp_path)
    rolled = call(capsys, "jog", "--rig", rig, "--axis", "roll", "--to", 90, "--read", "--json").document["readings"]
    pitched = call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--to", 90, "--read", "--json").document["readings"]
    level = call(capsys, "jog", "--rig", rig, "--json").document["readings"]
    assert rolled["dmm.y"]["mean_v"] == pytest.approx(-2.48, abs=0.02)
    assert pitched["dmm.x"]["mean_v"] == pytest.approx(2.5, abs=0.02)
    assert level["dmm.z"]["mean_v"] == pytest.approx(-2.52, abs=0.02)
