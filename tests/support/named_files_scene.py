"""A small run whose rig file and procedure file name others: dialects, a list of index errors, points of a design."""

from importlib.resources import files
from pathlib import Path

from small_run import Bench, bench

DIALECT, INDEX_ERRORS, POINTS = "mytable.toml", "index.csv", "points.csv"
MOVE = 'command = "{axis} MOVE {target_deg:+09.4f}"'
OTHER_MOVE = 'command = "{axis} GOTO {target_deg:+09.4f}"'
_ROWS = "".join(f"{pitch},{roll}\n" for roll in (-180, -90, 0, 90) for pitch in (-30, 0, 30))
_OF_THE_AXIS = "uncertainty_arcsec = 5.0\n"


def bench_with_files(folder: Path) -> Bench:
    """Return it, its files in ``folder``."""
    shipped = files("rig").joinpath("dialects/dual-axis-1deg.toml").read_text(encoding="utf-8")
    (folder / DIALECT).write_text(shipped, encoding="utf-8")
    (folder / INDEX_ERRORS).write_text(
        "angle_deg,error_arcsec,uncertainty_arcsec\n-180,1.0,0.2\n0,-1.0,0.2\n180,1.0,0.2\n", encoding="utf-8"
    )
    (folder / POINTS).write_text(f"pitch_deg,roll_deg\n{_ROWS}", encoding="utf-8")
    both = f'speed_dps = 180.0\ndialect = "{DIALECT}"\n'
    return bench(
        folder,
        rig=(
            ("speed_dps = 180.0\naxis = 1\n", f'{both}axis = 1\n{_OF_THE_AXIS}index_table = "{INDEX_ERRORS}"\n'),
            ("speed_dps = 180.0\naxis = 2\n", f"{both}axis = 2\n"),
        ),
        procedure=(
            (
                'kind = "D"\npitch_deg = { from = -30.0, to = 30.0, step = 30.0 }\n'
                "roll_deg = { from = -180.0, to = 90.0, step = 90.0 }\n",
                f'kind = "file"\nfile = "{POINTS}"\n',
            ),
        ),
    )


def replace_text(path: Path, was: str, becomes: str) -> None:
    """Replace a piece of a file's text."""
    text = path.read_text(encoding="utf-8")
    assert was in text, was
    path.write_text(text.replace(was, becomes), encoding="utf-8")
