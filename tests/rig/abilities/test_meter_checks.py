"""Laws of a meter's checks: short and reference on the ranges in use, its own calibration when its temperature moves.

ACAL DCV takes 2 minutes 45 seconds (3458A user's guide); the inputs must be open meanwhile.
"""

import re
import tomllib
from pathlib import Path

import pytest
from daq_rig import WIRING as DAQ_WIRING
from daq_rig import DaqRig, daq_rig
from gpib_rig import WIRING, GpibRig, gpib_rig, meter_settings
from pydantic import ValidationError

from rig.abilities.self_checking import SelfChecking
from rig.devices.hp3458a import Hp3458aChecks, Hp3458aReadout
from rig.errors import DeviceFault, WaitEnded
from rig.twins.physics.known_voltages import OUTPUT_OHM, REFERENCE, SHORT

SHORT_V, REFERENCE_V = 2e-6, 10.00003
CHECKS = {"short_scanner": 5, "short_limit_v": 2e-5, "reference_scanner": 6, "reference_v": 10.0}
DAQ_CHECKS = {"short_channel": 210, "short_limit_v": 2e-5, "reference_channel": 211, "reference_v": 10.0}


def _meter() -> GpibRig:
    ohm = {"short": OUTPUT_OHM[SHORT], "reference": OUTPUT_OHM[REFERENCE]}
    rig = gpib_rig(wiring={**WIRING, 105: "short", 106: "reference"}, output_ohm=ohm)
    rig.bench.level_v |= {"short": SHORT_V, "reference": REFERENCE_V}
    return rig


def _daq() -> DaqRig:
    rig = daq_rig(wiring={**DAQ_WIRING, 210: "short", 211: "reference"})
    rig.bench.level_v |= {"short": SHORT_V, "reference": REFERENCE_V}
    return rig


def test_short_and_reference_are_read_on_the_ranges_in_use() -> None:
    channels = {"x": {"scanner": 1, "range_v": 10.0}, "y": {"scanner": 2, "range_v": 1.0}}
    rig = _meter()
    readout = rig.prepared(channels=channels, checks={**CHECKS, "reference_limit_v": 1e-4, "samples": 4})
    look = readout.check_itself(rig.wait)
    assert [proof.what for proof in look.proofs] == ["short on 1 V", "short on 10 V", "reference on 10 V"]
    # The bench adds 1 µV a reading: the mean of readings 1 to 4 is 2.5 µV up, of 9 to 12 10.5 µV.
    assert [proof.value_v for proof in look.proofs] == pytest.approx([4.5e-6, 8.5e-6, 10.0000405], abs=1e-9)
    assert all(proof.is_good for proof in look.proofs)
    assert (look.temperature_degc, look.is_calibrated_anew) == (36.4, False)
    assert [channel for channel, _ in rig.bench.readings] == ["short"] * 8 + ["reference"] * 4
    assert rig.scanner.closed_channels() == {106}


def test_a_range_that_reads_wrong_is_no_good_proof() -> None:
    rig = _meter()
    rig.bench.level_v["reference"] = 10.001
    look = rig.prepared(checks={**CHECKS, "reference_limit_v": 1e-4}).check_itself(rig.wait)
    assert [proof.is_good for proof in look.proofs] == [True, False]
    rig.bench.level_v["short"] = 50.0  # overloaded on 10 V
    assert not rig.prepared(checks={**CHECKS}).check_itself(rig.wait).proofs[0].is_good


@pytest.mark.parametrize(("level_v", "is_seen"), [(-2.0, True), (0.5, True), (0.001, False)])
def test_a_contact_that_is_welded_shows_at_the_short_though_no_query_shows_it(level_v: float, is_seen: bool) -> None:
    # Behind 100 ohm and its contacts it drives level / 101 ohm through the 0.51 ohm of the short's branch.
    rig = _meter()
    rig.bench.level_v |= {"dmm.y": level_v, "short": 0.0}
    rig.scanner.welded.add(102)
    (short, _) = rig.prepared(checks=CHECKS).check_itself(rig.wait).proofs
    assert short.value_v == pytest.approx(level_v * 0.51 / 101.01, abs=2e-5)
    assert short.is_good is not is_seen


def test_without_a_limit_a_reading_is_recorded_and_not_judged() -> None:
    rig = _meter()
    rig.bench.level_v["reference"] = 5.0
    (_, reference) = rig.prepared(checks={**CHECKS}).check_itself(rig.wait).proofs
    assert reference.is_good
    assert reference.value_v == pytest.approx(5.0, abs=1e-4)


def test_a_data_acquisition_unit_reads_them_too() -> None:
    rig = _daq()
    look = rig.prepared(checks={**DAQ_CHECKS, "reference_limit_v": 1e-4}).check_itself(rig.wait)
    assert [proof.what for proof in look.proofs] == ["short on 10 V", "reference on 10 V"]
    assert all(proof.is_good for proof in look.proofs)
    assert look.temperature_degc is None
    rig.bench.level_v["short"] = -1e-3
    assert not rig.prepared(checks=DAQ_CHECKS).check_itself(rig.wait).proofs[0].is_good


def _calibrating(rig: GpibRig) -> Hp3458aReadout:
    readout: Hp3458aReadout = rig.prepared(checks={"autocalibrate": True})
    return readout


def test_the_meter_calibrates_itself_once_and_again_when_its_temperature_has_moved_by_one_degree() -> None:
    rig = _meter()
    readout = _calibrating(rig)
    assert readout.needs_check()
    assert readout.check_itself(rig.wait).is_calibrated_anew
    for inside_degc, is_needed in ((36.4, False), (37.3, False), (35.5, False), (37.4, True)):
        rig.meter.inside_degc = lambda _now_s, degc=inside_degc: degc
        assert readout.needs_check() is is_needed
        assert readout.check_itself(rig.wait).is_calibrated_anew is is_needed
    assert len(rig.meter.calibrated_s) == 2
    assert not readout.needs_check()


def test_every_relay_is_open_while_the_meter_calibrates_itself() -> None:
    rig = _meter()
    readout = _calibrating(rig)
    readout.read("dmm.x", 1, rig.wait)
    closed: list[frozenset[int]] = []
    heard = rig.meter.listen

    def listen(message: bytes, now_s: float) -> float:
        if message.startswith(b"ACAL"):
            closed.append(rig.scanner.closed_channels())
        return heard(message, now_s)

    rig.meter.listen = listen
    began_s = rig.clock.monotonic_s()
    readout.check_itself(rig.wait)
    assert closed == [frozenset()]
    assert 165.0 <= rig.clock.monotonic_s() - began_s < 170.0
    assert readout.read("dmm.x", 1, rig.wait).samples[0] == pytest.approx(1.0, abs=1e-4)


def test_a_calibration_that_fails_or_never_ends_is_a_fault() -> None:
    rig = _meter()
    readout = _calibrating(rig)
    rig.meter.cannot_calibrate = True
    with pytest.raises(DeviceFault, match="ACAL DCV: CALIBRATION ERROR; nothing is measured"):
        readout.check_itself(rig.wait)
    assert readout.needs_check()


def test_a_stop_during_the_calibration_leaves_the_meter_cleared() -> None:
    rig = _meter()
    readout = _calibrating(rig)

    def wait(duration_s: float) -> None:
        if duration_s > 100.0:
            raise WaitEnded("stop")
        rig.clock.sleep(duration_s)

    with pytest.raises(WaitEnded):
        readout.check_itself(wait)
    assert readout.needs_check()


def test_a_readout_whose_file_asks_for_nothing_is_not_checked() -> None:
    for readout in (gpib_rig().readout(), daq_rig().readout()):
        assert isinstance(readout, SelfChecking)
        assert readout.check_every_s is None


@pytest.mark.parametrize(
    ("checks", "expected"),
    [
        ({"short_scanner": 1}, "the short is on channel 101, which belongs to a sensor"),
        ({"short_scanner": 5, "reference_scanner": 105, "reference_v": 1.0}, "the reference is on channel 105"),
        ({"reference_scanner": 5}, "belong together"),
        ({"reference_v": 5.0}, "belong together"),
        ({"short_limit_v": 1e-5}, "no channel of the short"),
        ({"reference_scanner": 5, "reference_v": 50.0}, "fits on no range"),
        ({"short_scanner": 5, "samples": 1}, "greater than or equal to 2"),
    ],
)
def test_checks_that_prove_nothing_are_refused(checks: dict[str, object], expected: str) -> None:
    with pytest.raises(ValidationError, match=expected):
        meter_settings(checks=checks)


def test_the_example_on_the_page_is_what_the_driver_takes() -> None:
    page = (Path(__file__).parents[3] / "docs" / "meter-and-scanner.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```toml\n(checks = .*?)```", page, re.DOTALL)
    checks = tomllib.loads(example)["checks"]
    assert meter_settings(checks=checks).checks.asks_for_anything
    assert set(checks) == set(Hp3458aChecks.model_fields)


def test_no_burst_and_no_check_measures_a_channel_on_another_range() -> None:
    rig = _meter()
    readout = rig.prepared(checks={**CHECKS, "reference_limit_v": 1e-4})
    messages: list[bytes] = []
    heard = rig.meter.listen

    def listen(message: bytes, now_s: float) -> float:
        parts = [part for part in message.split(b";") if not part.endswith(b"?")]
        messages.extend(part for part in parts if part.startswith((b"DCV", b"RANGE", b"ARANGE")))
        return heard(message, now_s)

    rig.meter.listen = listen
    for channel in ("dmm.x", "dmm.y", "dmm.x"):
        readout.check_itself(rig.wait)
        readout.read(channel, 2, rig.wait)
    assert set(messages) == {b"DCV 10"}
