"""What is told of drivers of other distributions that lack something: by name, before it is needed, and no more."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from command import call
from example_files import EXAMPLE_RIG
from table_bench import virtual_clock
from turner_rig import turner_rig

from procedures.records.dwells import Event
from procedures.report.conditions import condition_sections
from procedures.run.watch.watchdogs import Watchdogs
from rig.assembly.open_rig import open_rig
from rig.assembly.prove import prove
from rig.assembly.unguarded import unguarded_sentences
from rig.defects import defect_text
from rig.description.read import read_rig
from rig.drivers.driver import Driver
from rig.drivers.twin_lines import axis_lines
from rig.errors import DescriptionError, DeviceFault
from rig.link.byte_stream import ByteStream
from rig.link.memory import MemoryStream
from rig.motion.move import stop_all
from rig.twins.physics.world import World

UNSTOPPED = (
    "axes.pitch: nothing stops it when calrig dies: its driver has no stop_steps; a move that was started goes on to"
    " its target; keep the machine's own stop button within reach"
)
REAL_PORT = "socket://127.0.0.1:9"


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return turner_rig(tmp_path, monkeypatch)


def _axis_class() -> Any:
    return import_module("turner.device").Turner


def _only_positions(path: Path) -> Path:
    path.write_text(path.read_text(encoding="utf-8").replace("top_rate_dps = 60.0\n", ""), encoding="utf-8")
    return path


def _without_twin(monkeypatch: pytest.MonkeyPatch) -> None:
    package = import_module("turner")
    driver: Driver = package.DRIVER
    assert driver.axes is not None
    monkeypatch.setattr(package, "DRIVER", replace(driver, axes=replace(driver.axes, twin=None)))


def test_an_axis_that_nobody_stops_is_told_by_check_and_devices(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "nothing stops it" not in call(capsys, "check", "--rig", _only_positions(path)).out
    monkeypatch.delattr(_axis_class(), "stop_steps")
    for command in ("check", "devices"):
        outcome = call(capsys, command, "--rig", path)
        assert outcome.status == 0
        assert UNSTOPPED in outcome.out.replace("\n", " ")


def test_a_run_tells_it_of_axes_at_real_ports_and_the_page_keeps_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = read_rig(_only_positions(turner_rig(tmp_path, monkeypatch, REAL_PORT)))
    assert unguarded_sentences(real) == ()
    monkeypatch.delattr(_axis_class(), "stop_steps")
    assert unguarded_sentences(real)[0] == UNSTOPPED
    assert unguarded_sentences(real.all_on_twins()) == (), "twins in this process die with it"
    events: list[Mapping[str, object]] = []
    with open_rig(real.all_on_twins()) as rig:
        Watchdogs(rig, lambda _kind, detail: events.append(detail)).arm(rig.clock.sleep)
    journalled = [Event(n, rig.clock.now_utc(), 0.0, "watchdog", detail, "") for n, detail in enumerate(events)]
    assert UNSTOPPED in condition_sections(journalled)["watchdogs of the axes"]["pitch"]


@pytest.mark.parametrize("member", ["stop", "state", "check_target"])
def test_an_axis_that_lacks_a_member_is_refused_with_its_name(
    path: Path, member: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delattr(_axis_class(), member)
    sentence = f"axes.pitch: driver 'turner': its Turner has no {member}, which Axis in"
    with pytest.raises(DescriptionError, match=sentence):
        open_rig(read_rig(path))
    outcome = call(capsys, "check", "--rig", path)
    assert outcome.status == 2
    assert sentence in outcome.err


def test_an_axis_that_turns_must_say_how_it_is_stopped(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(_axis_class(), "stop_steps")
    with pytest.raises(DescriptionError, match="its Turner has no stop_steps, which Stoppable in"):
        open_rig(read_rig(path))
    open_rig(read_rig(_only_positions(path))).close()


def test_two_axes_of_one_zaber_are_told_apart(tmp_path: Path) -> None:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    for number in (1, 2):
        stage = f'driver = "zaber"\nport = "{REAL_PORT}"\nmicrostep_deg = 0.000234375\ndevice_axis = {number}\n'
        text = text.replace('driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\n', stage, 1)
    path = tmp_path / "rig.toml"
    path.write_text(text.replace("\naxis = 2\n", "\naxis = 1\n"), encoding="utf-8")
    assert axis_lines(read_rig(path).axes) == [("pitch", "roll")]
    path.write_text(path.read_text(encoding="utf-8").replace("device_axis = 2", "device_axis = 1"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"axis 1, 1 at .* is already pitch"):
        read_rig(path)


def test_a_device_without_a_twin_is_proven_alone_and_its_neighbours_beside_theirs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = read_rig(turner_rig(tmp_path, monkeypatch, REAL_PORT))
    clock = virtual_clock()
    stages = {name: rig.axes[name].model_copy(update={"port": "twin"}) for name in rig.axes}
    at_the_bench = import_module("turner.twin").twin(stages, World(rig.all_on_twins()), 1.0)
    _without_twin(monkeypatch)

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        return MemoryStream(at_the_bench, clock, key) if key == "axes.pitch" else open_line()

    proofs = {proof.key: proof for proof in prove(rig, tmp_path / "kept", clock=clock, line_source=source)}
    assert proofs["axes.pitch"].is_alone
    assert proofs["axes.pitch"].answers.compared["identity"] == "TURNER 7, drive 1"
    assert (tmp_path / "kept" / "device" / "axes.pitch.jsonl").exists()
    assert not proofs["environment.air"].is_alone
    assert proofs["axes.pitch"].differences == proofs["environment.air"].differences == ()
    with pytest.raises(DescriptionError, match="has no twin: it works at its real port"):
        open_rig(rig.all_on_twins())


def test_a_defect_of_a_driver_is_named_as_that_drivers(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    codec = import_module("turner.codec")
    monkeypatch.setattr(codec, "UNITS_PER_DEG", 0.0)  # a division by it, in a line of the driver
    outcome = call(capsys, "jog", "--rig", path, "--read")
    assert "this is a defect of the driver 'turner' of turner 1.0: ZeroDivisionError" in outcome.err
    assert "to whoever made it" in outcome.err


def test_a_defect_of_calrig_is_its_own() -> None:
    with pytest.raises(ZeroDivisionError) as caught:
        1 / 0  # noqa: B018
    assert defect_text(caught.value).startswith("a defect of calrig: ZeroDivisionError")


def test_a_stop_that_breaks_is_told_with_whose_defect_it_is(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with open_rig(read_rig(path)) as rig:
        monkeypatch.setattr(import_module("turner.codec"), "encode", None)
        with pytest.raises(DeviceFault, match=r"a defect of the driver 'turner' of turner 1.0: "):
            stop_all(dict(rig.axes), rig.clock)
