"""Laws of jogging by command: the limits of the rig hold, the machine must be homed, and a refusal moves nothing."""

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from command import call
from job_files import job, simulated
from table_bench import rig_file
from turning_rig import SERVO_FOR_PITCH, STAGE_FOR_ROLL, served

from rig.clock import ScaledClock
from rig.description.read import read_rig
from rig.lines.lock import acquire

BY_HAND = (
    'driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\n',
    'driver = "manual"\nport = "twin"\nincrement_deg = 1.0\narrival_tolerance_deg = 0.05\n',
)


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
    (("--axis", "pitch", "--to", 10.5), "multiples of 1°"),
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


@pytest.fixture(scope="module")
def turning_bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A rig file whose roll axis is a stage that turns and whose pitch axis is a servo, on real ports."""
    folder = tmp_path_factory.mktemp("turning")
    with served(folder, ScaledClock(30.0), STAGE_FOR_ROLL, SERVO_FOR_PITCH) as (_, rig):
        yield rig


def test_a_rate_is_measured_and_ends_at_rest(turning_bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    roll = ("jog", "--rig", turning_bench, "--axis", "roll")
    assert call(capsys, *roll, "--home").status == 0
    outcome = call(capsys, *roll, "--rate", -4, "--for", 30, "--json").document
    assert outcome["rate_dps"] == pytest.approx(-4.0, abs=0.05 + outcome["rate_limit_dps"])
    assert outcome["turned_deg"] == pytest.approx(-120.0, abs=15.0)
    assert call(capsys, *roll, "--rate", 24.5, "--for", 1).status == 2
    again = call(capsys, "jog", "--rig", turning_bench, "--samples", 2, "--json").document
    assert again["positions_deg"]["roll"] == pytest.approx(outcome["position_deg"], abs=0.001), "it stands"


def test_readings_of_an_axis_that_somebody_left_turning_say_so(
    turning_bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By bytes of another program, as a dead process leaves it: bare voltages would pass for those of an attitude."""
    look = ("jog", "--rig", turning_bench, "--read", "--samples", 2, "--json")
    assert call(capsys, *look).document["moving"] == []
    host, port = read_rig(turning_bench).axes["roll"].port.removeprefix("socket://").rsplit(":", 1)
    with socket.create_connection((host, int(port)), timeout=10.0) as other:
        other.sendall(b"/1 1 move vel 655\n")  # 0.2°/s in the stage's unit, 1.6384 × microsteps a second
        other.recv(100)
    told = call(capsys, *look)
    assert told.document["moving"] == ["roll"]
    assert "roll: moves: +" in told.err
    assert "calrig jog --stop stops it" in told.err
    assert call(capsys, "jog", "--rig", turning_bench, "--stop", "--json").status == 0
    assert call(capsys, *look).document["moving"] == []


def test_a_stop_sees_the_axes_stand(turning_bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "jog", "--rig", turning_bench, "--stop", "--json").document
    assert outcome["stopped"] == ["pitch", "roll"]
    outcome = call(capsys, "jog", "--rig", turning_bench, "--stop", "--axis", "roll", "--json").document
    assert outcome["stopped"] == ["roll"]


def test_a_servo_stays_homed_from_one_command_to_the_next(
    turning_bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pitch = ("jog", "--rig", turning_bench, "--axis", "pitch")
    assert call(capsys, *pitch, "--home").status == 0
    for target_deg in (20, -10):
        outcome = call(capsys, *pitch, "--to", target_deg, "--json")
        assert outcome.document["position_deg"] == pytest.approx(target_deg, abs=0.03)


def test_a_rig_that_a_run_owns_is_refused_with_its_owner(
    turning_bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with acquire([str(turning_bench)], "run night-12"):
        outcome = call(capsys, "jog", "--rig", turning_bench, "--axis", "roll", "--to", 0)
    assert outcome.status == 1
    assert f"in use by process {os.getpid()} (run night-12) since" in outcome.err


TURN_REFUSALS = [
    (("--axis", "pitch", "--rate", 1, "--for", 1), "pitch: this axis only goes to positions"),
    (("--axis", "roll", "--rate", 1), "--rate and --for belong together"),
    (("--axis", "roll", "--to", 1, "--for", 1), "--rate and --for belong together"),
    (("--axis", "roll", "--rate", 1, "--for", 0), "--for: got 0 s"),
    (("--rate", 1, "--for", 1), "--rate needs --axis"),
    (("--axis", "yaw", "--stop"), "no axis 'yaw' (allowed: pitch, roll)"),
    (("--set", "x.json"), "belong to the screen, which needs a terminal"),
]


@pytest.mark.parametrize(("options", "sentence"), TURN_REFUSALS, ids=[" ".join(map(str, r[0])) for r in TURN_REFUSALS])
def test_an_unclear_rate_is_refused(
    turning_bench: Path, capsys: pytest.CaptureFixture[str], options: tuple[object, ...], sentence: str
) -> None:
    outcome = call(capsys, "jog", "--rig", turning_bench, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err


def _beside_a_twin(folder: Path, pitch: str) -> Path:
    """The example with that in place of the pitch table's driver and port; roll stays a twin of the command's own."""
    table = 'driver = "indexing-table"\nport = "twin"'
    return rig_file(folder, (table, pitch), ('time = "virtual"', "time = 200.0"))


def test_a_machine_beside_a_twin_is_not_homed_unasked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mixed").mkdir()
    with served(tmp_path, ScaledClock(200.0)) as (simulated_rig, _):
        machine = f'driver = "indexing-table"\nport = "{simulated_rig.addresses["axes.pitch"]}"'
        rig = _beside_a_twin(tmp_path / "mixed", machine)
        outcome = call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--to", 10)
        assert outcome.status == 2
        assert "pitch: the axis is not homed, so its position is not known; nothing moved" in outcome.err
        assert call(capsys, "jog", "--rig", rig, "--axis", "roll", "--to", 10).status == 0


def test_an_operator_is_asked_for_the_zero_and_then_for_the_attitude(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the terminal of another place: nobody remembers where an axis stood that was set by hand."""
    with served(tmp_path, ScaledClock(200.0), BY_HAND) as (_, rig):
        outcome = call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--to", 10, "--json")
    assert outcome.document["position_deg"] == pytest.approx(10.0, abs=0.05)
