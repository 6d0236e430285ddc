"""Laws of symptoms: bytes that are no reply name their likely cause."""

import pytest

from rig.link.symptoms import remedy


@pytest.mark.parametrize(
    ("sent", "received", "words"),
    [
        (b"1 POS?\r\n", b"", "nothing came at all"),
        (b"1 POS?\r\n", b"1 POS?\r\n1 POS +010.0000\r\n", "an echo"),
        (b"\xae", b"\xae\x01", "an echo"),
        (b"1 POS?\r\n", bytes.fromhex("8e12c702b2be2b1effeb6d"), "baud rate and parity"),
        (b"1 POS?\r\n", b"1 POS +01", "otherwise"),
        (b"1 POS?\r\n", b"1 POS +01\xb0.0000\r\n", "otherwise"),  # one flipped bit is no baud rate
        (bytes.fromhex("0103025e0001e460"), bytes.fromhex("9f306de8424be4"), "otherwise"),  # no text was asked for
    ],
)
def test_bytes_that_are_no_reply_name_their_likely_cause(sent: bytes, received: bytes, words: str) -> None:
    assert words in remedy(sent, received, "otherwise")
