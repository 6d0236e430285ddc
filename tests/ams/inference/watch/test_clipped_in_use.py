"""A package that a program uses: rows at a rail, and of an output that hangs, have no angle and a flag."""

import numpy as np
from package_outputs import TRUTH, output_v
from solved_sets import tp_set

from ams.attitude import flag_codes
from ams.in_use import PackageInUse, PackageStream

ROWS, SD_V, RAIL_V = 600, 2e-5, 1.5


def _used() -> tuple[PackageInUse, dict[str, np.ndarray], np.ndarray]:
    """Return a package of two axes, what it reads where x cannot leave its rails, and which rows are at one."""
    rows, chance = np.arange(ROWS), np.random.default_rng(4)
    pitch, roll = 45.0 * np.sin(2.0 * np.pi * rows / 61.0), 10.0 * np.sin(2.0 * np.pi * rows / 97.0)
    true_v = {a: np.array([output_v(a, TRUTH[a], *at) for at in zip(pitch, roll, strict=True)]) for a in "xy"}
    read = {axis: np.round(values + SD_V * chance.standard_normal(ROWS), 7) for axis, values in true_v.items()}
    read["x"] = np.clip(read["x"], -RAIL_V, RAIL_V)
    package = PackageInUse(tp_set("xy", SD_V, np.random.default_rng(1)), reading_sd_v=SD_V)
    return package, read, np.abs(read["x"]) == RAIL_V


def test_no_row_at_a_rail_has_an_angle() -> None:
    package, read, at_rail = _used()
    found = package.attitude(read)
    assert np.array_equal((found.codes & np.uint64(flag_codes.CLIPPED)) != 0, at_rail)
    assert np.array_equal(np.isnan(found.pitch_deg), at_rail)
    assert found.is_good[~at_rail].all()
    assert "output clipped at a rail: taken as missing" in found.flags[np.flatnonzero(at_rail)[0]]


def test_a_stream_flags_from_the_proof_on() -> None:
    package, read, at_rail = _used()
    stream = PackageStream(package)
    pieces = [stream.feed({axis: values[[row]] for axis, values in read.items()}) for row in range(ROWS)]
    is_told = (np.concatenate([piece.codes for piece in pieces]) & np.uint64(flag_codes.CLIPPED)) != 0
    assert not is_told[~at_rail].any()
    assert is_told[300:][at_rail[300:]].all()


def test_an_output_that_hangs_is_missing() -> None:
    package, read, _ = _used()
    read["x"] = np.round(0.5 * read["x"], 7)
    read["x"][100:200] = read["x"][100]
    found = package.attitude(read)
    assert np.isnan(found.pitch_deg[101:200]).all()
    assert all("output frozen" in flag for flag in found.flags[101:200])
