"""Laws of a run whose axes move, and whose meters read, at the same time: the same record in less time."""

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from asking import put
from killing import run_child
from small_run import Bench, bench, dwells_of, measured, resumed

from procedures.errors import ExitStatus
from procedures.journal.requests.spool import Spool
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from rig.abilities.abilities import Burst, Readout, Wait
from rig.assembly.open_rig import Rig, open_rig
from rig.errors import DescriptionError, DeviceNonsense

METER = '[readouts.{name}]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 1\n'
METERS = "".join(
    METER.format(name=name) + f"channels = {{ {axis} = {{ scanner = 1, range_v = 10.0 }} }}\n"
    for name, axis in (("dmm", "x"), ("second", "y"), ("third", "z"))
)
ONE_METER = METER.format(name="dmm") + (
    "channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, "
    "z = { scanner = 3, range_v = 10.0 } }\n"
)
THREE = ((ONE_METER, METERS), ('"dmm.y"', '"second.y"'), ('"dmm.z"', '"third.z"'))
TOGETHER = (("[sensors.SN1]", "[motion]\ntogether = true\n[reading]\ntogether = true\n[sensors.SN1]"),)
PROCEDURE = (("replications = 2", "replications = 1"), ("samples = 5", "samples = 20"))


class Noting:
    """A readout that notes where the axes are whenever a burst begins and ends, and who else is reading."""

    def __init__(self, readout: Readout, seen: "Watched") -> None:
        self._readout, self._seen = readout, seen
        self.name, self.channels = readout.name, readout.channels
        self.identify, self.prepare = readout.identify, readout.prepare
        self.reading_s, self.checks = readout.reading_s, readout.checks

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        self._seen.begins(channel)
        burst = self._readout.read(channel, samples, wait, nplc)
        self._seen.ends(channel)
        return burst


class Watched:
    """A rig whose readouts are watched."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self.readouts: Mapping[str, Readout] = {name: Noting(readout, self) for name, readout in rig.readouts.items()}  # type: ignore[misc]
        self.reading: set[str] = set()
        self.most_at_once = 0
        self.order: list[str] = []
        self.on_begin: dict[tuple[str, int], Callable[[], object]] = {}

    def __getattr__(self, name: str) -> object:
        return getattr(self._rig, name)

    def begins(self, channel: str) -> None:
        self._require_rest()
        self.reading.add(channel)
        self.order.append(channel)
        self.on_begin.get((channel, self.order.count(channel)), lambda: None)()
        self.most_at_once = max(self.most_at_once, len(self.reading))

    def ends(self, channel: str) -> None:
        self._require_rest()
        self.reading.remove(channel)

    def _require_rest(self) -> None:
        assert not any(axis.state().is_moving for axis in self._rig.axes.values()), "an axis moves while reading"


def _run(small: Bench, run_dir: Path) -> tuple[Watched, Outcome, float]:
    run_dir.mkdir()
    with open_rig(small.rig) as rig:
        watched = Watched(rig)
        outcome = begin(run_dir, small.header(run_dir), small.plan, watched)  # type: ignore[arg-type]
        assert outcome.state is State.FINISHED
        return watched, outcome, rig.clock.monotonic_s()


@pytest.fixture(scope="module")
def in_turn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Bench, Path, float]:
    small = bench(tmp_path_factory.mktemp("in_turn"), THREE, PROCEDURE)
    watched, _, took_s = _run(small, small.folder / "run")
    assert watched.most_at_once == 1
    return small, small.folder / "run", took_s


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> tuple[Bench, Path, float, Watched]:
    small = bench(tmp_path_factory.mktemp("together"), THREE + TOGETHER, PROCEDURE)
    watched, _, took_s = _run(small, small.folder / "run")
    return small, small.folder / "run", took_s, watched


def test_a_run_together_measures_bit_by_bit_what_a_run_in_turn_does(
    in_turn: tuple[Bench, Path, float], together: tuple[Bench, Path, float, Watched]
) -> None:
    """The chance of a reading is counted by step, channel and reading, so nothing may hang on who reads beside it."""
    assert measured(dwells_of(together[1])) == measured(dwells_of(in_turn[1]))


def test_the_meters_read_at_once_and_no_axis_moves_meanwhile(together: tuple[Bench, Path, float, Watched]) -> None:
    small, run_dir, _, watched = together
    assert watched.most_at_once == 3
    assert watched.reading == set()
    for dwell in dwells_of(run_dir):
        assert list(dwell.readings) == list(small.plan.channels)
        began = [reading.started_s for reading in dwell.readings.values()]
        assert max(began) - min(began) < 0.2


def test_what_check_expects_to_be_gained_is_gained(
    in_turn: tuple[Bench, Path, float], together: tuple[Bench, Path, float, Watched]
) -> None:
    expected_s = in_turn[0].plan.expected.p50_s - together[0].plan.expected.p50_s
    assert expected_s > 0.15 * in_turn[0].plan.expected.p50_s
    assert in_turn[2] - together[2] == pytest.approx(expected_s, rel=0.1)


def test_readings_expected_together_take_as_long_as_the_longest_readout(tmp_path: Path) -> None:
    """Two of three channels of 20 readings, 2 × 1 cycles of 50 Hz each, and the shorter way of every move are saved."""
    folders = [tmp_path / name for name in ("turn", "both")]
    for folder in folders:
        folder.mkdir()
    turn, both = (
        bench(folder, THREE + more, PROCEDURE).plan for folder, more in zip(folders, ((), TOGETHER), strict=True)
    )
    dwells = len(turn.dwells)
    saved_moving_s = 0.0
    for here, there in zip(turn.dwells, turn.dwells[1:], strict=False):
        ways_s = [abs(there.targets_deg[name] - here.targets_deg[name]) / 180.0 for name in there.targets_deg]
        saved_moving_s += min(way_s + 1.3 for way_s in ways_s) if all(ways_s) else 0.0
    saved_reading_s = dwells * 2 * 20 * 2 * 1 / 50
    assert turn.expected.p50_s - both.expected.p50_s == pytest.approx(saved_moving_s + saved_reading_s)
    assert (both.moving_together, both.reading_together) == (("pitch", "roll"), ("dmm", "second", "third"))
    assert (turn.moving_together, turn.reading_together) == ((), ())


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ("[reading]\ntogether = true\n", r"rig\.toml:\d+: reading\.together: true, but it needs at least two readouts"),
        ("[motion]\ntogether = 1\n", r"motion\.together: .*(true|bool)"),
    ],
)
def test_a_declaration_that_the_rig_cannot_keep_is_refused(tmp_path: Path, table: str, sentence: str) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        bench(tmp_path, (("[sensors.SN1]", f"{table}[sensors.SN1]"),))


def test_a_reading_that_fails_leaves_no_meter_reading_and_the_dwell_is_repeated(tmp_path: Path) -> None:
    """One of three meters garbles an answer: the attempt is void, all three are prepared again, the run is whole."""
    small = bench(tmp_path, THREE + TOGETHER, PROCEDURE)
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with open_rig(small.rig) as rig:
        watched = Watched(rig)
        broken = watched.readouts["second"]
        plain, calls = broken.read, []

        def read(channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
            calls.append(channel)
            if len(calls) == 4:
                wait(0.3)
                raise DeviceNonsense("second: garbled")
            return plain(channel, samples, wait, nplc)

        broken.read = read  # type: ignore[method-assign]
        outcome = begin(run_dir, small.header(run_dir), small.plan, watched)  # type: ignore[arg-type]
    assert (outcome.state, outcome.exit_status) == (State.FINISHED, ExitStatus.DONE)
    assert all(dwell.attempt == 1 for dwell in dwells_of(run_dir))


@pytest.mark.parametrize("crash", ["move-sent:9", "acquiring:40"])
def test_a_run_killed_with_several_under_way_goes_on_to_the_same_record(
    together: tuple[Bench, Path, float, Watched], tmp_path: Path, crash: str
) -> None:
    small, uninterrupted = together[0], together[1]
    run_dir = tmp_path / "run"
    assert run_child(lambda _observer: small.run(run_dir), crash).was_killed
    assert resumed(run_dir).state is State.FINISHED
    assert measured(dwells_of(run_dir)) == measured(dwells_of(uninterrupted))


def test_an_abort_while_the_meters_read_ends_all_of_them_and_the_rig_answers_afterwards(tmp_path: Path) -> None:
    small = bench(tmp_path, THREE + TOGETHER, PROCEDURE)
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with open_rig(small.rig) as rig:
        watched = Watched(rig)
        watched.on_begin = {("third.z", 4): lambda: put(Spool(run_dir), "abort", "anna", "enough")}
        outcome = begin(run_dir, small.header(run_dir), small.plan, watched)  # type: ignore[arg-type]
        assert outcome.state is State.ABORTED
        assert watched.reading == {"dmm.x", "second.y", "third.z"}  # all three had begun, none was done
        for name, readout in rig.readouts.items():
            burst = readout.read(readout.channels[0], 3, rig.clock.sleep)
            assert burst.samples.size == 3, name
