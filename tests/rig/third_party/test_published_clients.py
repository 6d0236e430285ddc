"""Other people's clients against the twins of meters, chambers and controllers that speak text.

All are dependencies of the tests. What a client gets wrong stands in docs/drivers.md, "Other people's clients", with
the manual's page where one was read. Clients of Modbus are in ``test_modbus_libraries.py`` and ``test_mbpoll.py``,
zaber-motion in ``tests/rig/twins/test_zaber.py``, pyvisa on a GPIB in ``tests/rig/twins/test_pyvisa.py``.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import pytest
import pyvisa
from meter_rig import MODELS, meter_rig
from motion_bench import motion_bench
from pyvisa.resources import MessageBasedResource

from rig.clock import ScaledClock, SystemClock
from rig.twins.ascii_chamber import AsciiChamberTwin
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp

FACTOR = 50.0
pytestmark = pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::ResourceWarning")
"""pymeasure warns that it does not know of some instruments whether they speak SCPI."""


class Room:
    """What a chamber's twin asks of the world."""

    def __init__(self) -> None:
        self.held_degc = 25.0

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 25.0

    def setpoint_degc(self, environment: str) -> float:
        return self.held_degc

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.held_degc = setpoint_degc


def _socket(server: TwinServer) -> str:
    host, port = server.address.removeprefix("socket://").split(":")
    return f"TCPIP::{host}::{port}::SOCKET"


def _pymeasure(server: TwinServer, **line: Any) -> Any:
    adapters = import_module("pymeasure.adapters")
    where = _socket(server) if server.address.startswith("socket://") else f"ASRL{server.address}::INSTR"
    return adapters.VISAAdapter(where, visa_library="@py", timeout=3000, **line)


@pytest.mark.parametrize("model", MODELS)
def test_pyvisa_sets_up_and_reads_a_meter_on_a_socket(model: str) -> None:
    rig = meter_rig(model)
    rig.level_v[0] = 1.5
    manager = pyvisa.ResourceManager("@py")
    with serve_tcp(rig.port, SystemClock()) as server:
        meter = manager.open_resource(_socket(server), read_termination="\n", write_termination="\n")
        assert isinstance(meter, MessageBasedResource)
        meter.write("*RST")
        meter.write("VOLT:DC:RANG 20" if model == "keithley-2002" else "VOLT:DC:RANG 10")
        meter.write("VOLT:DC:NPLC 0.2")
        assert float(meter.query("READ?")) == 1.5
        assert meter.query("SYST:ERR?").endswith('0,"No error"')
        meter.close()
    manager.close()


def test_pymeasure_reads_a_34401a() -> None:
    hp = import_module("pymeasure.instruments.hp")
    rig = meter_rig("34401A")
    with serve_tcp(rig.port, SystemClock()) as server:
        meter = hp.HP34401A(_pymeasure(server, read_termination="\n", write_termination="\n"))
        meter.function_, meter.range_, meter.nplc = "DCV", 10, 1
        meter.auto_input_impedance_enabled = True
        assert (meter.nplc, meter.range_, meter.auto_input_impedance_enabled) == (1.0, 10.0, True)
        assert (meter.terminals_used, meter.reading) == ("FRONT", 1.0)
        meter.adapter.close()
    assert not rig.port.errors


def test_pymeasure_reads_a_keithley_2000() -> None:
    keithley = import_module("pymeasure.instruments.keithley")
    rig = meter_rig("keithley-2000")
    with serve_tcp(rig.port, SystemClock()) as server:
        meter = keithley.Keithley2000(_pymeasure(server, read_termination="\n", write_termination="\n"))
        meter.write("*RST")
        assert meter.mode == "voltage"  # CONF? is answered with quotes
        meter.voltage_range, meter.voltage_nplc = 10, 1
        assert (meter.voltage_range, meter.voltage_nplc, meter.voltage) == (10.0, 1.0, 1.0)
        meter.adapter.close()
    assert not rig.port.errors


def test_pymeasure_runs_a_thermotron_3800_and_a_set_point_waits_for_the_start() -> None:
    # Its docstring: "After setpoint is set to a new value, the "run()" command must be called".
    thermotron = import_module("pymeasure.instruments.thermotron")
    room = Room()
    with serve_pty(AsciiChamberTwin("air", room, model="thermotron-3800"), SystemClock()) as server:
        oven = thermotron.Thermotron3800(_pymeasure(server, read_termination="\r\n", write_termination="\r"))
        oven.setpoint = 30.0
        assert room.held_degc == 25.0
        oven.run()
        assert (oven.setpoint, oven.temperature, oven.mode.value) == (30.0, 25.0, 16)
        assert room.held_degc == 30.0
        oven.adapter.close()


def test_pymeasure_rounds_a_target_of_the_esp301_to_six_digits() -> None:
    # It writes PA with %g: 123.456789 becomes 123.457. The page of PA was not seen; our driver sends six decimals.
    newport = import_module("pymeasure.instruments.newport")
    bench = motion_bench("esp301")
    heard: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (heard.append(data), receive(data, now_s))[1]
    with serve_tcp(bench.twin, ScaledClock(FACTOR)) as server:
        controller = newport.ESP300(_pymeasure(server, read_termination="\r\n", write_termination="\r"))
        controller.x.position = 123.456789
        assert isinstance(controller.x.position, float)
        controller.adapter.close()
    assert b"1PA123.457\r" in b"".join(heard)


@contextmanager
def _pipython(server: TwinServer) -> Iterator[Any]:
    sockets = import_module("pipython.pidevice.interfaces.pisocket")
    messages = import_module("pipython.pidevice.gcsmessages")
    commands = import_module("pipython.pidevice.gcs2.gcs2commands")
    host, port = server.address.removeprefix("socket://").split(":")
    with sockets.PISocket(host=host, port=int(port)) as gateway:
        yield commands.GCS2Commands(messages.GCSMessages(gateway))


def test_the_maker_s_own_client_moves_a_gcs_stage() -> None:
    bench = motion_bench("pi-gcs")
    with serve_tcp(bench.twin, ScaledClock(FACTOR)) as server, _pipython(server) as pi:
        assert pi.axes == ["1", "2"]
        assert pi.qSVO() == {"1": False, "2": False}
        with pytest.raises(Exception, match="Unallowable move attempted on unreferenced axis"):
            pi.MOV("1", 5.0)  # M863 p. 207, error 5
        pi.SVO("1", True)
        pi.FRF("1")
        assert pi.IsControllerReady()
        while any(pi.IsMoving().values()):
            pass
        assert pi.qFRF() == {"1": True, "2": False}
        pi.VEL("1", 50.0)
        pi.MOV("1", 5.0)
        while any(pi.IsMoving().values()):
            pass
        assert pi.qPOS("1")["1"] == pytest.approx(5.0)
        assert pi.qONT("1")["1"]
        pi.STP(noraise=True)  # error 10 is the sign that it was obeyed, M863 p. 207
        assert pi.qERR() == 0
