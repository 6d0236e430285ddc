"""How a package sits on the table."""

from typing import Literal

from pydantic import model_validator

from rig.toml_file import StrictTable

SENSOR_AXES = ("x", "y", "z")


def _signed(name: str, axis: str) -> int:
    return 0 if name[1] != axis else (1 if name[0] == "+" else -1)


def _determinant(rows: list[list[int]]) -> int:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


class Mount(StrictTable):
    """How the package sits on the table: which table axis each body axis points along."""

    x: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = "+x"
    y: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = "+y"
    z: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = "+z"
    datum: str = ""

    @model_validator(mode="after")
    def _right_handed_permutation(self) -> "Mount":
        rows = [[_signed(name, axis) for axis in SENSOR_AXES] for name in (self.x, self.y, self.z)]
        if _determinant(rows) != 1:
            left_out = [axis for axis in SENSOR_AXES if axis not in self.model_fields_set]
            taken = " and ".join(f"{axis} = '{getattr(self, axis)}'" for axis in left_out)
            raise ValueError(
                "mount must be a right-handed signed permutation of x, y and z"
                + (f"; {taken} was taken, since nothing is given there: give x, y and z" if left_out else "")
            )
        return self
