"""The check set of many channels: what stepped stands by itself, what stands is one row with its ranges."""

from dataclasses import replace

from procedures.report.sections.run import check_rows
from procedures.report.view import CheckComparison

ARCSEC_V = 1.212e-5
"""One arc second of a sensor of 2.5 V/g: 2.5 / 206265."""
CHECK = CheckComparison(2, "SN1 x", 6, ARCSEC_V, -3.0 * ARCSEC_V, "pitch 90°, roll 0°", 0.5 * ARCSEC_V, 2.5)


def _channels(count: int) -> list[CheckComparison]:
    return [
        replace(CHECK, label=f"SN{number} x", mean_change=number * ARCSEC_V, largest_change=-number * 3.0 * ARCSEC_V)
        for number in range(1, count + 1)
    ]


def test_few_channels_have_a_row_each() -> None:
    rows = check_rows(_channels(3))
    assert [(row.restart, row.about, row.mean, row.largest, row.judged) for row in rows] == [
        (1, "SN1 x", "1.0″", "−3.0″", "stands"),
        (1, "SN2 x", "2.0″", "−6.0″", "stands"),
        (1, "SN3 x", "3.0″", "−9.0″", "stands"),
    ]


def test_of_many_the_steps_come_first_and_the_others_are_one_row_a_restart() -> None:
    first = _channels(24)
    first[4] = replace(first[4], is_step=True)
    second = [replace(check, epoch=3) for check in _channels(24)]
    rows = check_rows([*first, *second])
    assert [(row.restart, row.about, row.judged) for row in rows] == [
        (1, "SN5 x", "step"), (1, "23 channels", "stand"), (2, "24 channels", "stand"),
    ]  # fmt: skip
    assert (rows[1].attitudes, rows[1].mean, rows[1].largest, rows[1].scatter) == ("6", "1.0″ to 24″", "−72″", "0.50″")
    assert rows[1].largest_at == "SN24 x, pitch 90°, roll 0°"


def test_channels_of_other_units_are_not_put_together() -> None:
    volts = [replace(check, sensitivity_v_per_g=0.0) for check in _channels(4)]
    rows = check_rows([*_channels(4), *volts])
    assert sorted(row.about for row in rows) == ["4 channels", "4 channels"]
    assert sorted("″" in row.largest for row in rows) == [False, True]
