from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from report_dwells import dwell, event

from ams.finding_kinds import FindingKind
from ams.findings import Finding
from ams.surveillance.common_mode import CommonMode
from procedures.common_mode.visit_watch import Judged
from procedures.records.dwells import DwellRecord
from procedures.report.stability import check_comparisons, reference_traces, restart_steps, temperature_traces
from procedures.run.ending import RunEnds
from procedures.run.judgement.history import History
from procedures.run.start_checks import require_no_step

LABELS = {"dmm.x": ("SN1 x", 2.5)}


def test_the_check_set_is_compared_attitude_by_attitude() -> None:
    before = [dwell(n, "check", 0, 0, pitch_deg=p, volts={"dmm.x": (p, p + 2e-6)}) for n, p in enumerate((0.0, 90.0))]
    after = [
        dwell(0, "check", 0, 0, pitch_deg=0.0, epoch=2, volts={"dmm.x": (1e-6, 3e-6)}),
        dwell(1, "check", 0, 0, pitch_deg=90.0, epoch=2, volts={"dmm.x": (90.0 + 5e-6, 90.0 + 7e-6)}),
    ]
    (found,) = check_comparisons([*before, *after], LABELS)
    assert found.attitudes == 2
    assert found.mean_change == pytest.approx(3e-6, abs=1e-12)
    assert found.largest_change == pytest.approx(5e-6, abs=1e-12)
    assert found.largest_at == "pitch 90°, roll 0°"
    # two samples 2 µV apart: s² = 2 µV², the mean's variance 1 µV², of a difference 2 µV²
    assert found.scatter == pytest.approx(np.sqrt(2.0) * 1e-6, rel=1e-6)


def test_one_epoch_has_nothing_to_compare() -> None:
    assert check_comparisons([dwell(0, "check", 0, 0)], LABELS) == ()


def test_reference_traces_start_at_zero_and_leave_out_rejected_visits() -> None:
    visits = [
        dwell(index, "reference", volts={"dmm.x": (volt, volt)}, accepted=index != 2)
        for index, volt in enumerate((1.0, 1.5, 9.0, 1.25))
    ]
    (trace,) = reference_traces(visits, LABELS)
    assert trace.change.tolist() == [0.0, 0.5, 0.25]
    assert trace.label == "SN1 x"


def test_temperature_is_traced_where_it_was_read() -> None:
    (trace,) = temperature_traces([dwell(0, degc=20.0), dwell(1, degc=None), dwell(2, degc=20.5)])
    assert trace.temperature_degc.tolist() == [20.0, 20.5]
    assert temperature_traces([dwell(0, degc=None)]) == ()


def _check(step: int, epoch: int, by_v: float) -> DwellRecord:
    chance = np.random.default_rng([step, epoch])
    return dwell(
        100 * epoch + step, "check", 0, 0, pitch_deg=30.0 * step, epoch=epoch,
        volts={"dmm.x": tuple(by_v + 1e-6 * chance.standard_normal(20))},
    )  # fmt: skip


def _sets(changes: Mapping[int, float], attitudes: Mapping[int, int]) -> list[DwellRecord]:
    found = [_check(step, epoch, by_v) for epoch, by_v in changes.items() for step in range(attitudes[epoch])]
    return [replace(entry, step=entry.step % 100) for entry in found]


def test_the_verdict_tells_of_a_restart_step_exactly_where_the_table_of_restarts_does() -> None:
    for by_v in (0.0, 2e-6, 5e-6, 1e-4):
        found = check_comparisons(_sets({1: 0.0, 2: by_v}, {1: 6, 2: 6}), LABELS)
        said = restart_steps(found)
        assert bool(said) == any(entry.is_step for entry in found) == (by_v > 1.5e-6)
    assert said[0].startswith("restart 1: SN1 x changed by +100 µV")


def test_fault_87_a_set_that_was_cut_short_is_compared_as_far_as_it_goes() -> None:
    (row,) = check_comparisons(_sets({1: 0.0, 2: 1e-4}, {1: 4, 2: 6}), LABELS)
    assert (row.attitudes, row.is_step) == (4, True)


def test_a_step_that_a_person_accepted_is_told_once() -> None:
    sets = _sets({1: 0.0, 2: 1e-4, 3: 1e-4}, {1: 6, 2: 6, 3: 6})
    opened = [event(location, "opened", location) for location in (1, 2)]
    accepted = [*opened, event(3, "state", 3, cause="seam", to="tripped"), event(4, "opened", 4)]
    assert [check_comparison.is_step for check_comparison in check_comparisons(sets, LABELS, accepted)] == [True, False]


def test_the_run_that_trips_and_its_report_name_the_same_channel_and_attitude() -> None:
    """Of sensors of unequal noise: the coarse one changes by more volts, the fine one by more of its limit."""
    labels = {"dmm.x": ("SN1 x", 2.5), "dmm.y": ("SN2 y", 2.5)}
    chance = np.random.default_rng(11)

    def check(step: int, epoch: int) -> DwellRecord:
        turned = (epoch - 1) * (1.0 + 0.5 * (step == 2))
        volts = {
            "dmm.x": tuple(3e-3 * turned + 1e-3 * chance.standard_normal(20)),
            "dmm.y": tuple(1e-4 * turned + 1e-6 * chance.standard_normal(20)),
        }
        return dwell(step, "check", 0, 0, pitch_deg=30.0 * step, epoch=epoch, volts=volts)

    before, after = ({step: check(step, epoch) for step in range(6)} for epoch in (1, 2))
    history = History(tuple(before.values()), 2, 1, 1)

    class Quiet:
        def event(self, kind: str, detail: Mapping[str, object]) -> None:
            assert kind == "seam"

        def compare_check_sets(self, *_given: object) -> None:
            return None

    with pytest.raises(RunEnds, match=r"dmm\.y at step 2 changed by 0\.00015 V") as ends:
        require_no_step(history, after, Quiet(), {}, Quiet(), is_alike=True)  # type: ignore[arg-type]
    assert "dmm.x" not in str(ends.value)
    (said,) = restart_steps(check_comparisons([*before.values(), *after.values()], labels))
    assert said == "restart 1: SN2 y changed by +150 µV at pitch 60°, roll 0°, and 1 other channel"


def test_a_set_at_another_temperature_is_drawn_and_not_judged() -> None:
    events = [event(1, "opened", 1), event(2, "opened", 2), event(3, "seam", 3, tested=False, reason="another plateau")]
    (row,) = check_comparisons(_sets({1: 0.0, 2: 1e-4}, {1: 6, 2: 6}), LABELS, events)
    assert not row.is_step


def test_visits_at_two_attitudes_have_a_trace_each() -> None:
    visits = [
        dwell(index, "reference", pitch_deg=30.0 * (index % 2), volts={"dmm.x": (volt, volt)})
        for index, volt in enumerate((1.0, 2.0, 1.5, 2.25))
    ]
    traces = reference_traces(visits, LABELS)
    assert [trace.change.tolist() for trace in traces] == [[0.0, 0.5], [0.0, 0.25]]
    assert traces[1].label == "SN1 x, pitch 30°, roll 0°"


def _shown(epoch: int, *findings: Finding) -> Judged:
    common = CommonMode((), 1e-9, (), {}, (), ("SN1", "SN2"))
    return Judged(0, "since the check set of epoch 1", common, findings, (), (1, 0.0), (epoch, 0.0), 0)


@pytest.mark.parametrize("by_v", [2e-7, 1e-4])
@pytest.mark.parametrize(
    ("kind", "whose"), [("table-rotation", "the table, its base"), ("meter-gain", "the gain of the meter")]
)
def test_a_restart_is_told_as_all_sensors_together_show_it(by_v: float, kind: FindingKind, whose: str) -> None:
    """Also where no channel alone is beyond its limit: the verdict tells a turn then, and the restart told none."""
    finding = Finding(kind, "all sensors did alike", True, 1e-9)
    sets = _sets({1: 0.0, 2: by_v, 3: by_v}, {1: 6, 2: 6, 3: 6})
    said = restart_steps(check_comparisons(sets, LABELS, (), [_shown(2, finding)]))
    assert said[0].startswith(f"restart 1: {whose}")
    assert [text.startswith("restart 2: SN1 x changed") for text in said[1:]] == [True] * (by_v > 1e-5)
