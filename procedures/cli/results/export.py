"""``calrig export`` and ``calrig verify``: a coefficient set for another system, and back."""

import os
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ams.exports.dcc_schema import SCHEMA, check_against_schemas
from ams.exports.formats import FORMATS, export_set, format_named, format_of, load_set
from ams.exports.verify import verify as verify_file
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_verdict import NOT_USABLE
from procedures.cli.options import Json, require_folder_of
from procedures.cli.output import print_json, say
from procedures.errors import RequestError

DCC_SCHEMAS = "CALRIG_DCC_SCHEMAS"
ToFormat = Annotated[str, Parameter(help=f"One of {', '.join(FORMATS)}.")]


def export(
    coefficient_set: Path,
    /,
    *,
    to: ToFormat,
    out: Path | None = None,
    json: Json = False,
) -> None:
    """Write a coefficient set for another system; `calrig verify` reads every format back.

    Parameters
    ----------
    coefficient_set
        A set: `coefficients/<sensor>.json` of a run, or an export of any format.
    out
        The file to write; by default beside the set, with the format's ending.
    """
    require_folder_of(out, "--out")
    wanted = format_named(to, str(coefficient_set))
    loaded = load_set(coefficient_set)
    loaded.check_vectors(str(coefficient_set))
    stem = coefficient_set.name[: -len(format_of(coefficient_set).ending)]
    target = out or coefficient_set.with_name(wanted.file_name(stem))
    if target.resolve() == coefficient_set.resolve():
        raise RequestError(f"{target}: is the set itself; give --out with another name; nothing was written")
    tell_export(loaded, to, target, json=json)


def tell_export(coefficients: CoefficientSet, to: str, target: Path, *, json: bool) -> None:
    """Write a set in a format and say what was written. Raises: SetError, WriteFailed."""
    loses = FORMATS[to].loses
    export_set(coefficients, to, target)
    if json:
        written = {"file": str(target), "format": to, "sensor": coefficients.sensor, "sha256": coefficients.sha256}
        print_json({**written, "loses": loses})
        return
    say(f"{target}: {coefficients.sensor}, format {to}, checksum {coefficients.sha256[:12]}")
    if loses is not None:
        say(f"The format loses: {loses}. The whole set is in the file all the same, for `calrig verify`.")


def verify(file: Path, /, *, json: Json = False) -> None:
    """Read an exported file back, check it, recompute its test vectors.

    Parameters
    ----------
    file
        A coefficient set or an export of any format.
    """
    found = verify_file(file)
    note = _check_schemas(file) if found.format == "dcc" else None
    if json:
        print_json({**asdict(found), "verified": True})
        return
    stamp = f"{found.standing}{', simulated' if found.simulated else ''}"
    say(f"{found.path}: intact ({found.format}, {found.sensor}, axes {', '.join(found.axes)}, {stamp})")
    if found.verdict == NOT_USABLE:
        say("The file is whole, and the calibration in it says that it is not usable: calrig show tells why.")
    say(
        f"{found.forward_vectors} test vectors forward and {found.inverse_vectors} inverse reproduced, "
        f"largest relative difference {found.largest_relative_error:.1e} (allowed {found.tolerance_relative:.0e})"
    )
    if note is not None:
        say(note)


def _check_schemas(file: Path) -> str:
    """Validate a file against the official schemas and return what to say of it.

    Raises: ams.errors.SetError where the file is none by them.
    """
    folder = os.environ.get(DCC_SCHEMAS)
    if not folder:
        return f"not validated against the official schemas: {DCC_SCHEMAS} is not set to the folder they are in"
    check_against_schemas(file, Path(folder))
    return f"valid by the official schema {SCHEMA}"
