"""How a package sits in a tunnel's model: one small rotation, solved from attitudes that are known, and stored.

A package is calibrated in its own axes and mounted as well as it can be. At attitudes that the tunnel knows (a
clinometer on the model, wind off) the force that the package tells and the one that the attitude makes differ by one
rotation R, f_model = R f_package, the same in all of them: Wahba's problem, by Markley's singular values. Two attitudes
that are not about one axis tell it; what is left over tells how well. A sensor in model axes is k' = R k, everything
else as it was.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.spread import PackageErrors, Part
from ams.errors import DesignError, SetError
from ams.frames import specific_force
from ams.inference.package.calibrated import CalibratedSensor
from ams.sets.canonical import Document, Json, checksum, listed, number, render, table, with_checksum
from ams.sets.instructions import declared_mount
from ams.whole_file import write_whole

FORMAT: Final = "calrig alignment"
VERSION: Final = 2
"""1 did not say what the known attitudes have in common."""
LARGEST_SD_DEG: Final = 1.0
"""About any axis: an alignment that is not told better is none."""


@dataclass(frozen=True)
class Alignment:
    """The rotation from package to model axes."""

    sensor: str
    rotation: FloatArray
    """(3, 3) with f_model = R f_package."""
    covariance_rad2: FloatArray
    """(3, 3) of the rotation vector by which it is wrong, model axes."""
    dof: int
    scatter_deg: float
    """Standard deviation of what the known attitudes leave over."""
    known_sd_rad: float | None = None
    """Standard uncertainty, about each axis, of what all known attitudes are wrong by alike; None: nothing is stated,
    and they count as exact but for their scatter."""

    def turn_parts(self) -> Sequence[Part]:
        """Return the independent (3, 3) parts of the covariance of the rotation vector, with degrees of freedom.

        What the known attitudes have in common turns the model, and no scatter tells it.
        """
        parts = [(self.covariance_rad2, float(self.dof))]
        if self.known_sd_rad:
            parts.append((self.known_sd_rad**2 * np.eye(3), float("inf")))
        return parts

    def document(self) -> Document:
        """Return the alignment as a sealed document."""
        covariance_deg2 = np.rad2deg(np.rad2deg(self.covariance_rad2))
        return with_checksum(
            {
                "format": FORMAT,
                "version": VERSION,
                "sensor": self.sensor,
                "rotation": [[float(value) for value in row] for row in self.rotation],
                "rotation_text": "f_model = rotation f_package",
                "covariance_deg2": [[float(value) for value in row] for row in covariance_deg2],
                "degrees_of_freedom": self.dof,
                "scatter_deg": self.scatter_deg,
                "known_sd_deg": None if self.known_sd_rad is None else float(np.rad2deg(self.known_sd_rad)),
            }
        )


def solve_alignment(
    sensor: str,
    found_rad: tuple[FloatArray, FloatArray],
    known_rad: tuple[FloatArray, FloatArray],
    known_sd_rad: float | None = None,
) -> Alignment:
    """Return the rotation between (N,) pitch and roll as the package tells them and as they are known.

    ``known_sd_rad``: standard uncertainty of what all known attitudes are wrong by alike. Rows of which an angle is
    not told are left out.

    Raises: DesignError where the attitudes do not tell the rotation.
    """
    found, true = (np.atleast_2d(specific_force(*angles)) for angles in (found_rad, known_rad))
    good = np.isfinite(found).all(axis=1) & np.isfinite(true).all(axis=1)
    found, true = found[good], true[good]
    if len(found) < 2:
        raise DesignError(
            f"{sensor}: alignment: got {len(found)} known attitudes, needed two or more; nothing was stored"
        )
    u, _, v = np.linalg.svd(true.T @ found)
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u) * np.linalg.det(v)]) @ v
    left = true - found @ rotation.T
    dof = 2 * len(found) - 3
    variance = float(np.sum(left**2)) / dof
    information = np.eye(3) * len(true) - true.T @ true
    with np.errstate(divide="ignore"):
        weakest = float(np.linalg.eigvalsh(information)[0])
    if weakest < 1e-3 or np.rad2deg(np.sqrt(variance / weakest)) > LARGEST_SD_DEG:
        raise DesignError(
            f"{sensor}: alignment: the {len(found)} known attitudes do not tell the rotation about every axis within "
            f"{LARGEST_SD_DEG:g}°; nothing was stored; add attitudes that differ in pitch and in roll"
        )
    covariance = np.asarray(variance * np.linalg.inv(information), dtype=float)
    return Alignment(sensor, rotation, covariance, dof, float(np.rad2deg(np.sqrt(variance))), known_sd_rad)


def as_mounted(sensor: str, document: Document) -> Alignment | None:
    """Return the turn from the fixture's axes, which a set is in, to the package's own; None where they are alike.

    Raises: DesignError where the set does not say how the package sat, or the turn is a reflection.
    """
    turned = declared_mount(document)
    if turned is None:
        raise DesignError(
            f"{sensor}: the set does not say how the package sat on its fixture; nothing was computed; leave "
            "--package-axes out, or give an alignment"
        )
    if np.linalg.det(turned) < 0.0:
        raise DesignError(
            f"{sensor}: the mount that the set declares makes a left-handed package, which no turn leads to; nothing "
            "was computed; leave --package-axes out, or give an alignment"
        )
    if np.array_equal(turned, np.eye(3)):
        return None
    return Alignment(sensor, turned, np.zeros((3, 3)), 1, 0.0, 0.0)


def store_alignment(alignment: Alignment, path: Path) -> None:
    """Write the file whole. Raises: WriteFailed."""
    write_whole(path, render(alignment.document()))


def load_alignment(path: Path) -> Alignment:
    """Return a stored alignment. Raises: SetError where the file is none, or was changed."""
    try:
        document = json.loads(path.read_bytes())
    except OSError as error:
        raise SetError(f"{path}: cannot be read: {error.strerror}; give the file of --solve-alignment") from None
    except ValueError:
        document = None
    if (
        not isinstance(document, dict)
        or document.get("format") != FORMAT
        or document.get("version") not in (1, VERSION)
    ):
        raise SetError(f"{path}: is no alignment of this version: give a file that --solve-alignment wrote")
    if table(document.get("checksum", {})).get("sha256") != checksum(document):
        raise SetError(f"{path}: checksum: does not fit the content: the file was changed; solve the alignment again")
    return Alignment(
        str(document["sensor"]),
        _matrix(document, "rotation"),
        np.deg2rad(np.deg2rad(_matrix(document, "covariance_deg2"))),
        int(number(document["degrees_of_freedom"])),
        number(document["scatter_deg"]),
        None if document.get("known_sd_deg") is None else float(np.deg2rad(number(document["known_sd_deg"]))),
    )


def _matrix(document: Mapping[str, Json], name: str) -> FloatArray:
    return np.array([[number(cell) for cell in listed(row)] for row in listed(document[name])])


@dataclass(frozen=True)
class AlignedSensor:
    """A calibrated sensor in the axes of the model that carries it."""

    sensor: CalibratedSensor
    rotation: FloatArray

    @property
    def offset_v(self) -> float:
        return self.sensor.offset_v

    @property
    def k_v_per_g(self) -> FloatArray:
        return np.asarray(self.rotation @ self.sensor.k_v_per_g)

    @property
    def is_linear(self) -> bool:
        return self.sensor.is_linear

    def line_output_v(self, output_v: FloatArray) -> FloatArray:
        """Return (N,) what the reading would be at the reference temperature."""
        return self.sensor.line_output_v(output_v)

    def quadratic_v(self, force: FloatArray) -> FloatArray:
        """Return (N,) what the terms of second and third order add at a force in model axes."""
        return self.sensor.quadratic_v(force @ self.rotation)

    def output_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the (N,) variance of prediction plus reading."""
        return self.sensor.output_variance_v2(force @ self.rotation)

    def calibration_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N,) parts of the prediction's variance."""
        return self.sensor.calibration_parts(force @ self.rotation)

    def reading_variance_v2(self, force: FloatArray) -> FloatArray:
        """Return the (N,) variance of a reading."""
        return self.sensor.reading_variance_v2(force)


@dataclass(frozen=True)
class AlignedPackage:
    """The axes of a package in model axes, with what their calibrations and the alignment have in common."""

    sensors: Sequence[AlignedSensor]
    together: PackageErrors | None
    alignment: Alignment

    def output_parts(self, force: FloatArray) -> Sequence[Part]:
        """Return the (N, S, S) parts of the covariance of the predictions.

        A rotation that is wrong by δ turns every k' by δ: its output by δ·(k' × f).
        """
        rotation = self.alignment.rotation
        calibrated = self._apart(force) if self.together is None else self.together.output_parts(force @ rotation)
        rows = np.stack([np.cross(sensor.k_v_per_g, force) for sensor in self.sensors], axis=-2)
        turned = [(rows @ part @ np.swapaxes(rows, -1, -2), dof) for part, dof in self.alignment.turn_parts()]
        return [*calibrated, *turned]

    def _apart(self, force: FloatArray) -> list[Part]:
        size, parts = len(self.sensors), []
        for index, sensor in enumerate(self.sensors):
            for variance, dof in sensor.calibration_parts(force):
                covariance = np.zeros((*np.shape(variance), size, size))
                covariance[..., index, index] = variance
                parts.append((covariance, dof))
        return parts
