"""A servo is stopped at the position that its controller tells; a number that is no position moves nothing."""

import os
import select
import threading
import tty
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest

from rig.guard.process import Line
from rig.wire.maestro import GET_POSITION, SET_TARGET, MaestroCodec, encode_word, get_position

CODEC = MaestroCodec(None, has_crc=False)
NEUTRAL = 6000
"""1500 µs in quarters."""


@contextmanager
def _controller(positions: Mapping[int, int]) -> Iterator[tuple[int, str, list[bytes]]]:
    """A line to a controller that tells these positions by channel; yields its descriptor, path and the targets set."""
    far, near = os.openpty()
    for end in (far, near):
        tty.setraw(end)
    targets: list[bytes] = []
    is_over = threading.Event()

    def serve() -> None:
        heard = b""
        while True:
            if not select.select([far], [], [], 0.02)[0]:
                if is_over.is_set():  # only once nothing is left to be read
                    return
                continue
            try:
                heard += os.read(far, 64)
            except OSError:  # the line was closed, and all that was sent has been read
                return
            while len(heard) >= 2:
                if heard[0] == GET_POSITION:
                    os.write(far, encode_word(positions[heard[1]]))
                    heard = heard[2:]
                elif heard[0] == SET_TARGET and len(heard) >= 4:
                    targets.append(heard[:4])
                    heard = heard[4:]
                else:
                    break

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield near, os.ttyname(near), targets
    finally:
        is_over.set()
        thread.join()
        os.close(far)


@pytest.mark.parametrize("damaged", [0, 0x4000, 0x4000 + NEUTRAL, 0xFFFF])
def test_a_position_of_more_than_14_bits_is_no_target_and_keeps_no_other_servo_from_its_stop(damaged: int) -> None:
    """The protocol has 14 bits for a target (Pololu, Set Target); 0 would end the pulses."""
    with _controller({0: damaged, 1: NEUTRAL}) as (descriptor, path, targets):
        aim = {"device": None, "has_crc": False}
        axes = {
            name: [{"send": CODEC.encode(get_position(channel)).hex(), "aim": {"channel": channel, **aim}}]
            for channel, name in enumerate(("pitch", "roll"))
        }
        line = Line({"name": "servos", "address": path, "is_escaped": False, "axes": axes}, descriptor)
        outcomes: dict[str, str] = {}
        line.stop(None, outcomes)
        os.close(line.descriptor)
    assert outcomes == {
        "pitch": "NOT told to stop: the controller does not say where the servo is",
        "roll": "told to stop",
    }
    assert targets == [bytes((SET_TARGET, 1, NEUTRAL & 0x7F, NEUTRAL >> 7))]
