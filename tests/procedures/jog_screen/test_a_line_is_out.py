"""A bench one of whose lines is out: nothing moves until every line is open again, and the others are kept."""

from pathlib import Path

from cut_line import cut_line
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.values import GoTo, Home
from procedures.jog_screen.worker import Bench
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock
from rig.description.read import read_rig

CLOCK = SystemClock()
WITHIN_S = 60.0


def _until(bench: Bench, words: str, times: int = 1) -> None:
    until_s = CLOCK.monotonic_s() + WITHIN_S
    while (text := f"{[line.text for line in bench.view.messages]}").count(words) < times:
        assert CLOCK.monotonic_s() < until_s, text
        bench.guard.answer()
        CLOCK.sleep(0.02)


def test_nothing_moves_while_a_meter_is_out_and_the_bench_goes_on_when_it_is_back(tmp_path: Path) -> None:
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (simulated, file):
        meter = simulated.addresses["readouts.dmm"].removeprefix("prologix+").partition("#")[0]
        with cut_line(meter) as dead:
            file.write_text(file.read_text(encoding="utf-8").replace(meter, dead.address), encoding="utf-8")
            with open_rig(read_rig(file), rig_file=file) as rig:
                log = ActionLog(tmp_path / "actions.jsonl", CLOCK)
                bench = Bench(rig, log, Snapshots(tmp_path / "snapshots.csv", CLOCK), CLOCK)
                try:
                    bench.start()
                    bench.ask(Home("roll"))
                    _until(bench, "roll: homed")
                    dead.cut(refusals=1_000_000)
                    _until(bench, "readouts.dmm")
                    bench.ask(GoTo("roll", 10.0))
                    _until(bench, "nothing moves until every line is open again")
                    assert simulated.world.attitude_deg("roll", CLOCK.monotonic_s()) == 0.0
                    simulated.world.slip("roll", 1.0, CLOCK.monotonic_s(), seen=True)
                    _until(bench, "roll: was moved, though nothing told it to: left at 0°, now at 1°")
                    _until(bench, "home it; one that you turned by hand needs no more than that")
                    dead.cut(refusals=0)
                    _until(bench, ", 'every line is open again'")
                    bench.ask(Home("roll"))
                    _until(bench, "roll: homed", times=2)
                    bench.ask(GoTo("roll", 10.0))
                    _until(bench, "roll: at rest at +10.0")
                finally:
                    bench.close()
                    log.close()
