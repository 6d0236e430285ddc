"""Lines that are lost are opened again whatever is on them, and no other line is."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from instrument_rigs import daq_and_f4t_rig_file

from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.errors import LinkClosed
from rig.link.byte_stream import ByteStream


@pytest.mark.parametrize("key", ["axes.pitch", "readouts.dmm", "environment.air", "streams.imu", "streams.board"])
def test_a_line_that_is_lost_is_opened_again_and_every_other_is_kept(tmp_path: Path, key: str) -> None:
    opened: list[tuple[str, ByteStream]] = []

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        opened.append((key, open_line()))
        return opened[-1][1]

    file = daq_and_f4t_rig_file(tmp_path)
    with open_rig(read_rig(file), rig_file=file, line_source=source) as rig:
        before, names = rig.identities(), list(rig.by_table())
        line = dict(opened)[key]
        line.close()
        opened.clear()
        # Chamber and board say who they are without being asked: somebody meets the loss.
        with suppress(LinkClosed):
            rig.environments["air"].temperature_degc()
            rig.streams["board"].start()
            rig.streams["board"].poll()
        assert rig.open_lost(rig.clock.monotonic_s() + 10.0) == ""
        assert [key for key, _ in opened] == [key]
        assert (rig.identities(), list(rig.by_table())) == (before, names)
