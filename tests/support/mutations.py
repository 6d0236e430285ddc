"""Files and lines turned into something nobody would write: the chance is a numpy Generator, so a finding repeats."""

import numpy as np

TOKENS = (
    b"nan", b"-inf", b"1e999", b"-0", b"1_0", b"0x1p-1074", b"true", b"null", b'""', b"''", b'"', b"[", b"]]", b"{",
    b"}", b"[" * 3000, b'{"a":' * 3000, b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\r", b"\r\n", b"\n\n", b",", b";", b"=",
    b"=1+1", b"9" * 400, b"1" * 5000, b"..", b"/", b"\\u0000", b"\\ud800", "Ω".encode(),
    b"#", b"%s", b"12:30:00", b"no",
)  # fmt: skip
MOST_CHANGES = 4


def mutated(data: bytes, chance: np.random.Generator, corpus: list[bytes]) -> bytes:
    """One to four changes of ``data``; pieces of the others in ``corpus`` may get in."""
    for _ in range(int(chance.integers(1, MOST_CHANGES + 1))):
        data = _changed(data, chance, corpus)
    return data


def _changed(data: bytes, chance: np.random.Generator, corpus: list[bytes]) -> bytes:
    at, until = sorted(int(n) for n in chance.integers(0, len(data) + 1, 2))
    until = min(until, at + int(chance.choice([1, 4, 16, 256, 4096])))
    other = corpus[int(chance.integers(len(corpus)))]
    match int(chance.integers(8)):
        case 0:
            return data[:at] + data[until:]
        case 1:
            return data[:until] + data[at:until] + data[until:]
        case 2:
            return data[:at] + TOKENS[int(chance.integers(len(TOKENS)))] + data[at:]
        case 3:
            return data[:at] + TOKENS[int(chance.integers(len(TOKENS)))] + data[until:]
        case 4:
            return data[:at] + chance.bytes(until - at) + data[until:]
        case 5:
            return data[:at]
        case 6:
            return data[:at] + other[at:until] + data[until:]
        case _:
            return _flipped(data, at, int(chance.integers(8)))


def _flipped(data: bytes, at: int, bit: int) -> bytes:
    if at >= len(data):
        return data
    return data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :]
