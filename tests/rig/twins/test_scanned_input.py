"""Relays that are closed together: the meter's volts against Kirchhoff's current law and against a divider by hand."""

import numpy as np
import pytest
from gpib_rig import Bench
from hypothesis import given
from hypothesis import strategies as st

from rig.twins.hp3488a import Hp3488aTwin
from rig.twins.scanned_input import CONTACT_OHM, OUTPUT_OHM, ScannedInput

CHANNELS = ("dmm.a", "dmm.b", "dmm.c")
WIRING = dict(zip((100, 101, 102), CHANNELS, strict=True))


def terminals_v(level_v: dict[str, float], close: bytes, output_ohm: dict[str, float], scanner: Hp3488aTwin) -> float:
    scanner.listen(close, 0.0)
    return ScannedInput(Bench(level_v), scanner, WIRING, output_ohm)(0.0)


def test_two_outputs_are_a_divider_between_their_volts() -> None:
    # 2 V behind 2499.5 ohm and 0.5 ohm, 0 V behind 499.5 ohm and 0.5 ohm: 2 V * 500 / 3000.
    ohm = {"dmm.a": 2499.5, "dmm.b": 499.5}
    assert CONTACT_OHM == 0.5
    volts = terminals_v({"dmm.a": 2.0, "dmm.b": 0.0}, b"CLOSE 100,101", ohm, Hp3488aTwin())
    assert volts == pytest.approx(1.0 / 3.0, abs=3e-6)  # the bench adds some microvolts


@given(
    st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3),
    st.lists(st.floats(0.01, 1e5), min_size=3, max_size=3),
)
def test_the_currents_into_the_terminals_add_up_to_none(levels_v: list[float], ohms: list[float]) -> None:
    volts = terminals_v(
        dict(zip(CHANNELS, levels_v, strict=True)), b"CLOSE 100,101,102", dict(zip(CHANNELS, ohms, strict=True)),
        Hp3488aTwin(),
    )  # fmt: skip
    added_v = 1e-6 * np.array([1, 2, 3])
    currents_a = (np.array(levels_v) + added_v - volts) / (np.array(ohms) + CONTACT_OHM)
    assert np.sum(currents_a) == pytest.approx(0.0, abs=1e-12 * (1.0 + np.sum(np.abs(currents_a))) * 10.0)


def test_one_relay_alone_passes_its_volts_whole_and_an_unwired_one_beside_it_changes_nothing() -> None:
    for close in (b"CLOSE 100", b"CLOSE 100,105"):
        assert terminals_v({"dmm.a": 2.0}, close, {}, Hp3488aTwin()) == 2.0 + 1e-6


def test_a_welded_contact_is_connected_though_its_relay_reads_open() -> None:
    scanner = Hp3488aTwin()
    scanner.welded.add(101)
    scanner.listen(b"VIEW 101", 0.0)
    assert scanner.talk(0.0)[0] == b"OPEN   1\r\n"
    assert OUTPUT_OHM > 0.0
    assert terminals_v({"dmm.a": 2.0, "dmm.b": 0.0}, b"CLOSE 100", {}, scanner) == pytest.approx(1.0, abs=3e-6)
