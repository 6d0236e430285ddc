"""Before the long run: the mount as declared, the channels warm."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from journals import a_dwell
from resumed import resume_on
from small_run import RIG, Bench, bench, dwells_of
from unattended_run import UnattendedRun, events, run_unattended, states

from procedures.errors import ExitStatus
from procedures.records.dwells import ChannelReading, DwellRecord
from procedures.records.states import State
from procedures.run.judgement.mount_check import contradictions
from procedures.run.preflight import preflight
from rig.abilities.abilities import Burst, Readout, Wait
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.description.rig_file import Mount, Sensor

LEVEL, ON_ITS_BACK, RIGHT_DOWN, NOSE_UP = (0.0, 0.0), (0.0, 180.0), (0.0, 90.0), (90.0, 0.0)
SENSOR = Sensor(
    model="three-axis package",
    channels={"x": "dmm.x", "y": "dmm.y", "z": "dmm.z"},
    nominal_sensitivity_v_per_g=2.5,
)
FELT_G = {
    LEVEL: (0.0, 0.0, -1.0),
    ON_ITS_BACK: (0.0, 0.0, 1.0),
    RIGHT_DOWN: (0.0, -1.0, 0.0),
    NOSE_UP: (1.0, 0.0, 0.0),
}
"""f of the conventions, by hand: level gives −g on z, roll +90° −g on y, nose up +g on x."""

NOON_UTC = datetime(2026, 3, 1, 12, tzinfo=UTC)


def _tumble(axes: str = "xyz", gains: tuple[float, float, float] = (2.5, 2.5, 2.5)) -> list[DwellRecord]:
    """Four attitudes; channel x of the meter is wired to the body axis axes[0], and so on."""
    chance = np.random.default_rng(1)
    dwells = []
    for attitude, felt_g in FELT_G.items():
        readings = {}
        for channel, axis, gain in zip(("dmm.x", "dmm.y", "dmm.z"), axes, gains, strict=True):
            volts = 0.01 + gain * felt_g["xyz".index(axis)] + chance.normal(0.0, 0.02, 5)
            readings[channel] = ChannelReading(channel, volts, 0.0, 0.1)
        pitch_deg, roll_deg = attitude
        dwells.append(replace(a_dwell(), readings=readings, measured_deg={"pitch": pitch_deg, "roll": roll_deg}))
    return dwells


def test_a_package_as_declared_is_not_contradicted() -> None:
    assert contradictions("SN1", SENSOR, _tumble()) == ()
    assert contradictions("SN1", SENSOR, _tumble(gains=(2.0, 3.0, 2.6))) == ()


def test_fault_62_a_reversed_polarity_is_named_by_axis_and_sign() -> None:
    assert contradictions("SN1", SENSOR, _tumble(gains=(2.5, -2.5, 2.5))) == (
        "SN1.y (dmm.y): declared along +y of the table, but it reads as -y: polarity reversed",
    )


def test_fault_60_swapped_channels_are_both_named() -> None:
    text = contradictions("SN1", SENSOR, _tumble(axes="yxz"))
    assert text == (
        "SN1.x (dmm.x): declared along +x of the table, but it reads as +y: another axis",
        "SN1.y (dmm.y): declared along +y of the table, but it reads as +x: another axis",
    )


def test_fault_62_a_declared_rotation_is_obeyed_and_an_undeclared_one_refused() -> None:
    """Turned by 90° about z: body x points along the table's y, body y along −x.

    Detected: the check set against the six signed table axes.
    Response: trip before the first design dwell; axis and sign are named.
    """
    turned = SENSOR.model_copy(update={"mount": Mount(x="+y", y="-x", z="+z")})
    as_turned = _tumble(axes="yxz", gains=(2.5, -2.5, 2.5))
    assert contradictions("SN1", turned, as_turned) == ()
    assert len(contradictions("SN1", SENSOR, as_turned)) == 2
    assert len(contradictions("SN1", turned, _tumble())) == 2


def test_fault_61_a_channel_that_does_not_respond_is_named() -> None:
    (text,) = contradictions("SN1", SENSOR, _tumble(gains=(2.5, 2.5, 0.0)))
    assert text.startswith("SN1.z (dmm.z): does not respond: it changed by 0.0")


def test_fault_69_a_sensitivity_of_another_unit_is_named() -> None:
    (text,) = contradictions("SN1", SENSOR, _tumble(gains=(2.5, 2.5, 25.0)))
    assert "SN1.z (dmm.z): sensitivity about 25 V/g, declared 2.5 V/g, allowed 0.5 to 2 times that" in text


def test_a_package_of_mixed_precision_is_judged_axis_by_axis() -> None:
    """TP's recommended package: x sharp, y and z blunt, z wired the other way round and declared so."""
    mixed = SENSOR.model_copy(update={"nominal_sensitivity_v_per_g": {"x": 2.5, "y": 0.5, "z": -0.5}})
    assert contradictions("SN1", mixed, _tumble(gains=(2.5, 0.5, -0.5))) == ()
    assert contradictions("SN1", mixed, _tumble(gains=(2.5, 0.5, 0.5))) == (
        "SN1.z (dmm.z): declared along +z of the table, but it reads as -z: polarity reversed",
    )
    (text,) = contradictions("SN1", SENSOR, _tumble(gains=(2.5, 0.5, 2.5)))
    assert text.startswith("SN1.y (dmm.y): sensitivity about 0.5")


def test_attitudes_that_cannot_tell_contradict_nothing() -> None:
    assert contradictions("SN1", SENSOR, _tumble()[:3]) == ()
    assert contradictions("SN1", SENSOR, [_tumble(gains=(-2.5, 2.5, 2.5))[0]] * 6) == ()


def test_fault_62_a_package_mounted_otherwise_than_declared_stops_before_the_first_design_dwell(
    tmp_path: Path,
) -> None:
    """The twin mounts as the file says, so the file that the run believes is turned against it."""
    small = bench(tmp_path)
    declared = small.plan.sensors["SN1"].model_copy(update={"mount": Mount(x="+y", y="-x", z="+z")})
    wrong = Bench(small.folder, small.rig, replace(small.plan, sensors={"SN1": declared}))
    outcome = wrong.run(tmp_path / "run")
    assert (outcome.state, outcome.exit_status, outcome.dwells_done) == (State.TRIPPED, ExitStatus.HELD, 0)
    assert "mount check: SN1.x (dmm.x): declared along +y of the table, but it reads as +x" in outcome.reason
    assert not [dwell for dwell in dwells_of(tmp_path / "run") if dwell.accepted], "the check set counts no more"


def test_after_the_package_was_put_right_the_check_set_is_the_new_baseline(tmp_path: Path) -> None:
    small = bench(tmp_path)
    mounted_wrongly = small.rig.model_copy(
        update={
            "sensors": {"SN1": small.rig.sensors["SN1"].model_copy(update={"mount": Mount(x="+y", y="-x", z="+z")})}
        }
    )
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    unattended = UnattendedRun(tmp_path / "night")
    assert run_unattended(Bench(small.folder, mounted_wrongly, small.plan), unattended).state is State.TRIPPED
    with open_rig(small.rig) as rig:
        assert resume_on(unattended.run_dir, rig, "carla", "turned it back").state is State.FINISHED
    assert not events(unattended.run_dir, "seam"), "there is no earlier check set that counts"
    assert states(unattended.run_dir)[2:] == ["tripped", "checking", "running", "finished"]


class Drifting:
    """A meter whose channel z comes to rest over an hour."""

    def __init__(self, readout: Readout, clock: object, tau_s: float) -> None:
        self._readout, self._clock, self._tau_s = readout, clock, tau_s

    def __getattr__(self, name: str) -> object:
        return getattr(self._readout, name)

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        burst = self._readout.read(channel, samples, wait, nplc)
        if channel != "dmm.z":
            return burst
        drift_v = 0.01 * np.exp(-self._clock.monotonic_s() / self._tau_s)  # type: ignore[attr-defined]
        return replace(burst, samples=burst.samples + drift_v)


class WarmingUp:
    """The rig with that meter."""

    def __init__(self, rig: object, tau_s: float) -> None:
        self._rig = rig
        self._meter = Drifting(rig.readouts["dmm"], rig.clock, tau_s)  # type: ignore[attr-defined]

    def __getattr__(self, name: str) -> object:
        return getattr(self._rig, name)

    @property
    def readouts(self) -> dict[str, object]:
        return {"dmm": self._meter}


GATE = '[chain."dmm.z"]\nwarm_up_s = 600.0\nwarm_up_slope_v_per_h = 2e-4\n[twin]'


@pytest.mark.parametrize(("tau_s", "least_s", "most_s"), [(1.0, 600.0, 900.0), (1200.0, 4000.0, 12_000.0)])
def test_nothing_is_measured_before_a_channel_is_warm_and_at_rest(
    tmp_path: Path, tau_s: float, least_s: float, most_s: float
) -> None:
    """dv/dt = −10 mV/τ·exp(−t/τ): with τ = 1200 s it falls below 0.2 mV/h after τ·ln(150) = 6013 s."""
    small = bench(tmp_path, rig=(("[twin]", GATE),))
    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(small, unattended, rig_of=lambda rig: WarmingUp(rig, tau_s)).state is State.FINISHED
    (warm,) = events(unattended.run_dir, "warm_up")
    assert least_s <= float(str(warm.detail["took_s"])) < most_s
    assert abs(float(str(warm.detail["slope_v_per_h"]))) <= 2e-4
    first = dwells_of(unattended.run_dir)[0]
    assert first.started_s >= least_s


def test_a_channel_that_never_comes_to_rest_trips(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("[twin]", GATE.replace("2e-4", "1e-9")),))
    outcome = run_unattended(small, UnattendedRun(tmp_path / "run"))
    assert outcome.state is State.TRIPPED
    assert "dmm.z: still drifts by" in outcome.reason
    assert "allowed 1e-09 V/h (rig file: chain.dmm.z.warm_up_slope_v_per_h); nothing was measured" in outcome.reason


def test_what_would_refuse_a_run_tonight_is_told_now(tmp_path: Path) -> None:
    small = bench(tmp_path)
    sound = preflight(tmp_path / "rig.toml", small.rig, small.plan, tmp_path / "runs", NOON_UTC)
    assert (sound.refusals, sound.engineering) == ((), ()), "twins are no calibration anyway"
    full = preflight(
        tmp_path / "rig.toml",
        small.rig,
        small.plan,
        tmp_path / "Dropbox" / "runs",
        NOON_UTC,
        lambda _: 1000,
    )
    assert "kept by a synchroniser" in full.refusals[0]
    assert "MB are free, the run needs" in full.refusals[1]


def test_fault_80_a_device_that_other_computers_reach_is_told(tmp_path: Path) -> None:
    """Detected: locks of this machine for all accounts and all names of a port; leases in an archive that is shared.
    Response: a second controller is refused and told who; without a shared archive it is told that nothing guards.
    """
    text = RIG.partition("[twin]")[0].replace('resource = "twin"', 'resource = "prologix+socket://192.0.2.7:1234#22"')
    path = tmp_path / "rig.toml"
    text = text.replace('driver = "watlow-f4"\nport = "twin"', 'driver = "watlow-f4"\nport = "socket://localhost:2"')
    path.write_text(text.replace('port = "twin"', 'port = "socket://localhost:1"'))
    found = preflight(path, read_rig(path), None, tmp_path / "runs", NOON_UTC)
    (sentence,) = found.unguarded
    assert sentence.startswith("socket://192.0.2.7:1234: nothing guards against a second computer")
    small = bench(tmp_path)
    assert preflight(path, small.rig, None, tmp_path / "runs", NOON_UTC).unguarded == ()


def test_a_rig_of_devices_is_told_what_its_results_will_lack(tmp_path: Path) -> None:
    text = RIG.partition("[twin]")[0].replace("axis = 1\n", 'axis = 1\nstandard = "table"\n')
    text = text.replace('resource = "twin"', 'resource = "prologix+socket://127.0.0.1:2#22"')
    text = text.replace('driver = "watlow-f4"\nport = "twin"', 'driver = "watlow-f4"\nport = "socket://127.0.0.1:3"')
    path = tmp_path / "rig.toml"
    path.write_text(
        text.replace('port = "twin"', 'port = "socket://127.0.0.1:1"')
        + '[standards.table]\nserial = "1"\ncertificate = "K-17"\ndue = 2026-02-28\n'
    )
    found = preflight(path, read_rig(path), None, tmp_path / "runs", NOON_UTC)
    assert "standards.table.due: 2026-02-28 is past" in found.refusals[0]
    assert "readouts.dmm: no standard stands behind it" in found.engineering


def test_a_standard_of_a_twin_that_is_past_is_not_said_to_end_with_the_run(tmp_path: Path) -> None:
    small = bench(tmp_path)
    path = tmp_path / "rig.toml"
    for due, said in (("2025-07-31", "2025-07-31 is past (today is "), (f"{NOON_UTC:%Y-%m-%d}", "is its last day")):
        standard = f'[standards.table]\nserial = "1"\ncertificate = "K-17"\ndue = {due}\n'
        path.write_text(f"{RIG}\n{standard}", encoding="utf-8")
        lasting = replace(small.plan, expected=replace(small.plan.expected, p90_s=3 * 86400.0))
        found = preflight(path, read_rig(path), lasting, tmp_path / "runs", NOON_UTC)
        about = [text for text in found.certificate if "standards.table" in text]
        assert len(about) == 1
        assert said in about[0]
