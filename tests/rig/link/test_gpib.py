import pytest

from rig.errors import RequestRefused
from rig.link.gpib import GpibResource, parse_resource


@pytest.mark.parametrize(
    ("text", "resource"),
    [
        ("twin", GpibResource("twin", "twin", 22)),
        ("prologix+socket://10.0.0.9:1234#22", GpibResource("prologix", "socket://10.0.0.9:1234", 22)),
        ("prologix+/dev/serial/by-id/usb-PX-if00#9", GpibResource("prologix", "/dev/serial/by-id/usb-PX-if00", 9)),
        ("prologix+rfc2217://lab:4000#0", GpibResource("prologix", "rfc2217://lab:4000", 0)),
        ("visa:GPIB0::22::INSTR", GpibResource("visa", "GPIB0", 22)),
        ("visa:gpib1::9::instr", GpibResource("visa", "gpib1", 9)),
    ],
)  # fmt: skip
def test_a_resource_is_a_carrier_a_port_and_an_address(text: str, resource: GpibResource) -> None:
    assert parse_resource(text, twin_address=22) == resource


@pytest.mark.parametrize(
    "text",
    ["", "TWIN", "prologix+socket://h:1", "prologix+#22", "prologix+/dev/x#31", "prologix+/dev/x#a", "visa:GPIB0::22",
     "visa:USB0::1::INSTR", "visa:GPIB0::99::INSTR", "visa:GPIB0::22::SOCKET", "/dev/ttyUSB0"],
)  # fmt: skip
def test_what_is_no_resource_is_refused_with_the_allowed_forms(text: str) -> None:
    with pytest.raises(RequestRefused, match=r"allowed: twin, prologix\+socket://host:port#address"):
        parse_resource(text, twin_address=22)


def test_instruments_of_one_adapter_share_its_bus() -> None:
    meter = parse_resource("prologix+socket://h:1234#22", 22)
    assert meter.bus == parse_resource("prologix+socket://h:1234#9", 9).bus
    assert meter.bus != parse_resource("prologix+socket://h:1235#9", 9).bus
