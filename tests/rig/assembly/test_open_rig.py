"""Laws of the assembly: the right clock, one lock, everything opened or nothing, recorded and replayed."""

import socket
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest
from table_bench import rig_file, virtual_clock

from rig.abilities.abilities import NoChance
from rig.assembly.open_rig import Rig, choose_clock, lock_rig, open_rig, real_ports
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock, VirtualClock
from rig.description.read import read_rig
from rig.errors import DescriptionError, DeviceFault, DeviceNonsense, LinkClosed, LinkLost, RigBusy
from rig.lines.lock import owner_of
from rig.lines.recording import recording, replaying
from rig.motion.jog import hold, home, jog_to
from rig.twins.physics.world import World


def _measured(rig: Rig) -> list[object]:
    """A small campaign: what was read, in bits."""
    wait, found = rig.clock.sleep, []
    for readout in rig.readouts.values():
        readout.prepare()
    for axis in rig.axes:
        home(rig, axis, wait)
    for step, (pitch_deg, roll_deg) in enumerate([(0.0, 0.0), (30.0, 60.0), (-90.0, 60.0)]):
        jog_to(rig, "pitch", pitch_deg, wait)
        jog_to(rig, "roll", roll_deg, wait)
        rig.chance.announce(step, "read", 0, step / 3)
        found += [rig.readouts["dmm"].read(f"dmm.{axis}", 3, wait).samples.tolist() for axis in "xyz"]
        found.append(rig.environments["air"].temperature_degc())
    return found


def test_two_runs_in_memory_read_the_same_bits(tmp_path: Path) -> None:
    description = read_rig(rig_file(tmp_path))
    with open_rig(description) as first:
        bits = _measured(first)
    with open_rig(description) as second:
        second.clock.sleep(12345.678)  # time has nothing to do with it
        assert _measured(second) == bits


def test_every_device_tells_who_it_is(tmp_path: Path) -> None:
    with open_rig(read_rig(rig_file(tmp_path))) as rig:
        identities = rig.identities()
    assert list(identities) == ["axes.pitch", "axes.roll", "readouts.dmm", "environment.air"]
    assert "3458A" in identities["readouts.dmm"]
    assert identities["axes.pitch"] != identities["axes.roll"]


def test_twins_with_equal_axis_numbers_are_two_controllers(tmp_path: Path) -> None:
    with open_rig(read_rig(rig_file(tmp_path, ("axis = 2", "axis = 1")))) as rig:
        home(rig, "pitch", rig.clock.sleep)
        assert not rig.axes["roll"].state().is_homed
        home(rig, "roll", rig.clock.sleep)
        jog_to(rig, "roll", 20.0, rig.clock.sleep)
        assert rig.axes["pitch"].state().position_deg == 0.0


@pytest.mark.parametrize(
    ("time", "kind"), [('"virtual"', VirtualClock), ('"real"', SystemClock), ("60.0", ScaledClock), ("60", ScaledClock)]
)
def test_the_clock_is_what_the_file_says(tmp_path: Path, time: str, kind: type) -> None:
    assert isinstance(choose_clock(read_rig(rig_file(tmp_path, ('time = "virtual"', f"time = {time}")))), kind)


def test_virtual_time_is_refused_at_a_real_port(tmp_path: Path) -> None:
    path = rig_file(tmp_path, ('driver = "watlow-f4"\nport = "twin"', 'driver = "watlow-f4"\nport = "/dev/ttyS99"'))
    with pytest.raises(DescriptionError, match=r"'virtual' cannot be kept at a real port \(/dev/ttyS99\)"):
        open_rig(read_rig(path))


def _real_rig(folder: Path, port: int) -> Path:
    """The axes behind one TCP port, chamber and meter behind the same number of other addresses; none is a twin."""
    text = rig_file(folder).read_text().split("\n[twin]\n")[0]
    text = text.replace(
        'driver = "watlow-f4"\nport = "twin"', f'driver = "watlow-f4"\nport = "socket://127.0.0.2:{port}"'
    )
    text = text.replace('port = "twin"', f'port = "socket://127.0.0.1:{port}"')
    path = folder / "real.toml"
    path.write_text(text.replace('resource = "twin"', f'resource = "prologix+socket://127.0.0.3:{port}#22"'))
    return path


def test_a_missing_port_is_told_and_the_lock_given_back(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    description = read_rig(_real_rig(tmp_path, port))
    assert real_ports(description) == [f"socket://127.0.0.{host}:{port}" for host in (1, 2, 3)]
    with pytest.raises(LinkLost, match=f"socket://127.0.0.1:{port}"):
        open_rig(description)
    assert owner_of(f"socket://127.0.0.1:{port}") is None


def test_a_port_that_is_in_use_is_not_opened(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener, ExitStack() as stack:
        description = read_rig(_real_rig(tmp_path, listener.getsockname()[1]))
        lock_rig(description, None, "run night.toml", stack)
        with pytest.raises(RigBusy, match=r"in use by process \d+ \(run night.toml\)"):
            open_rig(description)
        listener.settimeout(0.0)
        with pytest.raises(BlockingIOError):
            listener.accept()  # nobody knocked


def test_one_rig_file_has_one_controller(tmp_path: Path) -> None:
    path = rig_file(tmp_path)
    with open_rig(read_rig(path), rig_file=path, purpose="run"), pytest.raises(RigBusy, match=r"rig.toml: in use by"):
        open_rig(read_rig(path), rig_file=path, purpose="jog")
    open_rig(read_rig(path), rig_file=path).close()


def test_a_rig_without_twins_has_no_chance_to_tell(tmp_path: Path) -> None:
    path = rig_file(tmp_path)
    real = tmp_path / "axes_only.toml"
    real.write_text(path.read_text())
    description = read_rig(path).model_copy(update={"twin": None, "axes": {}, "readouts": {}, "environment": {}})
    with open_rig(description) as rig:
        assert isinstance(rig.chance, NoChance)
        assert isinstance(rig.clock, SystemClock)


def test_what_was_recorded_is_replayed_without_a_device(tmp_path: Path) -> None:
    description, clock = read_rig(rig_file(tmp_path)), virtual_clock()
    with (
        ExitStack() as files,
        open_rig(description, clock=clock, line_source=recording(tmp_path / "kept", files)) as rig,
    ):
        bits = _measured(rig)
    again = virtual_clock()
    with open_rig(description, clock=again, line_source=replaying(tmp_path / "kept", again)) as rig:
        assert _measured(rig) == bits
    other = virtual_clock()
    with (
        open_rig(description, clock=other, line_source=replaying(tmp_path / "kept", other)) as rig,
        pytest.raises(DeviceNonsense, match=r"axes\.pitch"),
    ):
        rig.axes["pitch"].start_move(10.0)


def test_a_replay_without_its_transcript_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"no transcript of axes\.pitch"):
        open_rig(read_rig(rig_file(tmp_path)), line_source=replaying(tmp_path, virtual_clock()))


def test_closing_leaves_no_thread(tmp_path: Path) -> None:
    before = threading.active_count()
    rig = open_rig(read_rig(rig_file(tmp_path)))
    rig.close()
    rig.close()
    assert threading.active_count() == before


def test_a_reconnected_rig_has_new_lines_to_the_same_machines(tmp_path: Path) -> None:
    with open_rig(read_rig(rig_file(tmp_path))) as rig:
        home(rig, "pitch", rig.clock.sleep)
        jog_to(rig, "pitch", 20.0, rig.clock.sleep)
        before, text = rig.axes["pitch"], rig.link_counts()["axes.pitch"].questions
        rig.reconnect()
        with pytest.raises(LinkClosed, match=r"axes\.pitch: used after it was closed"):
            before.state()
        assert rig.axes["pitch"].state().position_deg == 20.0
        assert text > rig.link_counts()["axes.pitch"].questions > 0
        assert set(rig.link_counts()) == {"axes.pitch", "readouts.dmm", "environment.air"}


def test_a_device_that_tells_its_serial_number_is_held_by_whatever_port_it_is_reached(tmp_path: Path) -> None:
    """Two addresses of one controller: two ports of a switch, a hub, a bridge that somebody set up beside the cable."""
    example = Path(__file__).parents[3] / "examples" / "rate-table" / "rig.toml"
    with ExitStack() as held:
        rigs = []
        for location in ("one", "other"):
            simulated = held.enter_context(serve_rig(read_rig(example), SystemClock()))
            described = write_rig(example, simulated.addresses, "real", tmp_path / f"{location}.toml")
            rigs.append(held.enter_context(open_rig(described.model_copy(update={"twin": None}))))
        first, second = rigs
        assert "serial" in first.identities()["axes.pitch"]
        with pytest.raises(RigBusy, match=r"(?s)device Zaber.*serial.*in use by"):
            second.identities()
        assert first.identities(), "asked again by its owner"


def test_a_chamber_that_was_set_by_hand_while_its_line_was_lost_is_left_as_it_is(tmp_path: Path) -> None:
    with open_rig(read_rig(rig_file(tmp_path))) as rig:
        rig.environments["air"].hold(30.0)
        rig.reconnect()
        rig.environments["air"].hold(31.0)
        assert isinstance(rig.chance, World)
        rig.chance.hold("air", 20.0, rig.clock.monotonic_s())
        rig.reconnect()
        with pytest.raises(DeviceFault, match="calrig set it to 31 °C, and now the set point is 20 °C"):
            rig.environments["air"].hold(30.0)
        assert rig.chance.setpoint_degc("air") == 20.0
        hold(rig, "air", 30.0)  # a person at the jog screen
        assert rig.chance.setpoint_degc("air") == 30.0
