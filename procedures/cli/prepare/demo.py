"""``calrig demo``: the whole job on the twin, for somebody who has never seen it."""

from importlib.resources import files
from pathlib import Path

from ams.whole_file import write_whole
from procedures.cli.options import Json
from procedures.cli.output import note
from procedures.cli.run.run import run
from procedures.errors import RequestError


def demo(*, out: Path = Path("demo-out"), json: Json = False) -> int:
    """Do the whole job on the twin: run, solve, archive, report, export.

    247 attitudes, 6 replications and 3 axes go through the devices' own bytes in virtual time. The rig and the
    procedure are written beside the result, to be read and changed.

    Parameters
    ----------
    out
        The folder to work in.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RequestError(
            f"--out {out}: cannot be worked in: {error.strerror}; nothing was written; give another folder"
        ) from error
    for name in ("rig.toml", "procedure.toml"):
        write_whole(out / name, files("procedures.demo").joinpath(name).read_bytes())
    note(f"rig and procedure: {out / 'rig.toml'}, {out / 'procedure.toml'}")
    return run(out / "procedure.toml", rig=out / "rig.toml", out=out / "runs", operator="demo", json=json)
