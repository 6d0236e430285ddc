"""``calrig attitude --solve-alignment``: how a package sits in its model, from attitudes that are known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.inference.inference import Package, inference
from ams.inference.package.alignment import LARGEST_SD_DEG, solve_alignment, store_alignment
from ams.inputs.hdf5_blocks import blocks_of
from procedures.cli.attitude.source import REMEDIES
from procedures.cli.options import require_folder_of
from procedures.cli.output import note
from procedures.errors import RequestError

TAKEN_AS_EXACT: Final = (
    "the known attitudes were taken as exact but for their scatter: an error that all of them share, such as a wrong "
    "zero of the reference, is in the angles and in no uncertainty; --known-sd-deg of --solve-alignment brings it in"
)


@dataclass(frozen=True)
class KnownAttitudes:
    """A file of them, and where the alignment goes that it tells."""

    data: Path
    out: Path
    sd_deg: float | None
    """Standard uncertainty of what they are all wrong by; None where nothing is stated."""

    def store_alignment_of(self, package: Package, reading_sd_v: float | None) -> None:
        """Solve how a package sits in the model, store it and tell it. Raises: ams.errors.AmsError."""
        require_folder_of(self.out, "--solve-alignment")
        if package.coefficients.doubt is not None:
            note(package.coefficients.doubt)
        found = inference(replace(package, alignment=None), None, reading_sd_v)
        known_deg: list[FloatArray] = []
        for readings in blocks_of(self.data, (*found.needed, "pitch_deg", "roll_deg"), found.optional, REMEDIES):
            angles = found.answer(readings).columns
            rows = angles["pitch_deg"], angles["roll_deg"], readings["pitch_deg"], readings["roll_deg"]
            known_deg.append(np.deg2rad(np.stack(rows)))
        pitch, roll, known_pitch, known_roll = np.concatenate(known_deg, axis=1)
        known_sd_rad = None if self.sd_deg is None else float(np.deg2rad(self.sd_deg))
        found_rad, known_rad = (pitch, roll), (known_pitch, known_roll)
        solved = solve_alignment(package.coefficients.sensor, found_rad, known_rad, known_sd_rad)
        store_alignment(solved, self.out)
        sd_deg = np.rad2deg(np.sqrt(np.diag(solved.covariance_rad2) + (known_sd_rad or 0.0) ** 2))
        spread = ", ".join(f"{axis} {sd:.2g}°" for axis, sd in zip("xyz", sd_deg, strict=True))
        shared = (
            TAKEN_AS_EXACT if self.sd_deg is None else f"in it {self.sd_deg:g}° that the known attitudes have in common"
        )
        note(
            f"alignment: {self.out}: told within {spread} (standard deviation about each axis of the model); the known "
            f"attitudes leave {solved.scatter_deg:.2g}° over; {shared}"
        )


def known_attitudes(
    data: str | None, out: Path | None, sd_deg: float | None, beside: Sequence[str]
) -> KnownAttitudes | None:
    """Return the known attitudes where an alignment is to be solved, else None.

    ``beside``: options that were given and would change nothing. Raises: RequestError.
    """
    if out is None:
        if sd_deg is not None:
            raise RequestError("--known-sd-deg: belongs to --solve-alignment, which is missing")
        return None
    if data is None:
        raise RequestError("--solve-alignment: known attitudes stand in a file: give DATA, not --stream")
    if beside:
        raise RequestError(
            f"--solve-alignment: stores an alignment and tells no angles: does not go with {', '.join(beside)}; "
            "nothing was stored; solve it first, then ask for angles with --alignment"
        )
    if sd_deg is not None and not 0.0 <= sd_deg <= LARGEST_SD_DEG:
        raise RequestError(
            f"--known-sd-deg: got {sd_deg:g}, allowed 0 to {LARGEST_SD_DEG:g}: the standard uncertainty of the known "
            "attitudes in degrees; nothing was stored"
        )
    return KnownAttitudes(Path(data), out, sd_deg)
