"""A rig file whose gravity cannot be that of its latitude is refused before a number is made with it.

By whatever makes numbers: a plan, a run, and a fit of observations that came from elsewhere. Smaller disagreements are
reservations of the result (:func:`procedures.solution.type_b.gravity_warnings`).
"""

from pathlib import Path

from ams.gravity import disagreement
from rig.description.read import rig_of
from rig.description.rig_file import RigDescription
from rig.toml_file import read_toml

KEY = ("rig", "gravity_mps2")


def read_rig_of_site(path: Path) -> RigDescription:
    """Read and check a rig file as :func:`rig.description.read.read_rig`, and its gravity against its place.

    Raises: rig.errors.DescriptionError naming file, line and key of every mistake.
    """
    file = read_toml(path)
    rig = rig_of(file)
    complaint = gravity_of_another_site(rig)
    if complaint is not None:
        raise file.error(KEY, complaint)
    return rig


def gravity_of_another_site(rig: RigDescription) -> str | None:
    """Return why the gravity of a rig cannot be that of its latitude; None where it can, or none is stated."""
    location = rig.rig
    if location.latitude_deg is None or location.gravity_mps2 is None:
        return None
    found = disagreement(location.gravity_mps2, location.latitude_deg, location.height_m)
    return None if found is None or found.kind != "refused" else found.text
