"""What manuals and logs of real units say of the ESP300 family: docs/devices/esp301.md."""

import pytest
from motion_bench import motion_bench

from rig.errors import DeviceRefused, RequestRefused
from rig.twins.esp301 import Esp301Twin
from rig.wire import esp301 as wire


def _said(twin: Esp301Twin, line: bytes, now_s: float) -> bytes:
    twin.receive(line, now_s)
    return twin.transmit(now_s)


@pytest.mark.parametrize(
    "line", [b"ESP300 Version 3.08 09/09/02", b"ESP301 Version 3.0.1 6/1/99", b"ESP302 Version 1.0"]
)
def test_every_member_of_the_family_is_known(line: bytes) -> None:
    # A log of an ESP300; the form found in clients' examples; "accept ESP30[012]" (EDH0414 for the 302).
    assert wire.decode_version(line) == line.decode("ascii")


def test_an_esp302_is_homed_and_moved() -> None:
    bench = motion_bench("esp301")
    bench.twin.version = "ESP302 Version 1.0"
    bench.home_all()
    bench.pitch.start_move(12.5)
    bench.clock.sleep(60.0)
    assert bench.pitch.state().position_deg == 12.5


def test_ts_is_one_character_of_bits() -> None:
    # E300 3-142: bits 0, 1, 2 = axis 1, 2, 3 in motion, bit 4 = power; "all at rest and power off `@` (40h), power on
    # `P` (50h), axis 1 moving `Q` (51h)" (computed).
    bench = motion_bench("esp301")
    twin: Esp301Twin = bench.twin
    assert _said(twin, b"TS\r", 0.0) == b"@\r\n"
    _said(twin, b"1MO\r", 0.0)
    assert _said(twin, b"TS?\r", 0.0) == b"P\r\n"
    _said(twin, b"1PA90\r", 0.0)
    assert _said(twin, b"TS\r", 1.0) == b"Q\r\n"


def test_what_other_clients_ask_is_answered_in_the_manuals_form() -> None:
    twin: Esp301Twin = motion_bench("esp301").twin
    assert _said(twin, b"1ID?\r", 0.0) == b"TS50DC.5, SN1263\r\n"  # E300 3-86, comma and blank
    assert _said(twin, b"PH\r", 0.0) == b"0H, 0H\r\n"  # E300 3-111: two hexadecimal words, `H, ` between
    assert _said(twin, b"1PH\r", 0.0) == b"0H, 0H\r\n"  # `01PH` → `18000606H, 6H` (log)
    assert float(_said(twin, b"1VU?\r", 0.0)) > 0.0  # a plain float (ESP302, driver)
    assert _said(twin, b"1QM?\r", 0.0).strip() in (b"0", b"1", b"2", b"3", b"4")  # one digit (EPICS README)
    assert _said(twin, b"1ZH?\r", 0.0).endswith(b"H\r\n")  # hexadecimal
    assert float(_said(twin, b"1SU?\r", 0.0)) > 0.0  # `0.00003539317` (log)
    assert float(_said(twin, b"1TV?\r", 0.0)) == 0.0
    assert _said(twin, b"TE?\r", 0.0) == b"0\r\n"


def test_defining_home_moves_nothing() -> None:
    # E302 (summary): DH "the present place becomes home without motion".
    twin: Esp301Twin = motion_bench("esp301").twin
    _said(twin, b"1MO;1PA30\r", 0.0)
    _said(twin, b"1DH\r", 100.0)
    assert float(_said(twin, b"1TP\r", 100.0)) == 0.0
    assert _said(twin, b"1MD?\r", 100.0) == b"1\r\n"


def test_degrees_prove_no_scale() -> None:
    # E300 3-133: "The unit of measure as used with this controller is intended as a label only."
    bench = motion_bench("esp301", resolution_deg=0.001)
    assert "0.001 deg a count" in bench.pitch.identify()
    bench.twin.axes[1].resolution_deg = 0.00003539317
    with pytest.raises(DeviceRefused, match=r"SU\) 3\.53932e-05° a count, the rig file says 0\.001 .*resolution_deg"):
        motion_bench_again(bench).identify()


def test_a_unit_that_somebody_changes_during_a_run_is_found_before_the_next_start() -> None:
    # E300 3-133: positions keep their numbers "and mean something else from then on".
    bench = motion_bench("esp301")
    bench.home_all()
    bench.pitch.start_move(5.0)
    bench.clock.sleep(60.0)
    _said(bench.twin, b"1SN9\r", bench.clock.monotonic_s())
    with pytest.raises(RequestRefused, match=r"in unit 9 \(SN\)"):
        bench.pitch.start_move(10.0)
    assert bench.true_deg == pytest.approx(5.0, abs=1e-3)


def motion_bench_again(bench: object) -> object:
    """The same twin, asked by a driver that has not asked before."""
    from rig.devices import esp301

    axes = {"pitch": bench.pitch._settings}  # type: ignore[attr-defined]
    return esp301.connect(axes, bench.stream)["pitch"]  # type: ignore[attr-defined]
