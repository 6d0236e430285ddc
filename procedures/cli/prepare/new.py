"""``calrig new``: the first rig file and procedure of a laboratory, from a few answers. Opens no port."""

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ams.whole_file import write_whole
from procedures.check.check_report import check
from procedures.check.new_files import Answers, first_procedure, rig_text, schemas
from procedures.cli.output import say
from procedures.errors import RequestError
from procedures.kinds.read import procedure_of
from procedures.numbers import duration
from rig.description.read import rig_of
from rig.errors import DescriptionError
from rig.toml_file import TomlFile

QUESTIONS = {
    "name": "Name of the rig",
    "gravity_mps2": "Local gravity, m/s²",
    "gravity_source": "Where that figure comes from",
    "pitch_port": "Port of the pitch axis (calrig devices lists them; twin: simulated)",
    "roll_port": "Port of the roll axis",
    "increment_deg": "Step of the table, degrees",
    "speed_dps": "Speed of the table, degrees per second",
    "uncertainty_arcsec": "Limit of its index errors, arc seconds",
    "meter": "Address of the 3458A (prologix+socket://HOST:1234#22; twin: simulated)",
    "sensor": "Serial number of the sensor",
    "axes": "Its axes: x, xz, xyz …",
    "sensitivity_v_per_g": "Its nominal sensitivity, V/g",
    "usage_deg": "Used at pitch from minus to plus, degrees",
}


def new(
    folder: Path = Path(),
    /,
    *,
    name: str | None = None,
    gravity_mps2: float | None = None,
    gravity_source: str | None = None,
    pitch_port: str | None = None,
    roll_port: str | None = None,
    increment_deg: float | None = None,
    speed_dps: float | None = None,
    uncertainty_arcsec: float | None = None,
    meter: str | None = None,
    sensor: str | None = None,
    axes: str | None = None,
    sensitivity_v_per_g: float | None = None,
    usage_deg: float | None = None,
) -> None:
    """Write a rig file and a procedure file that check passes, and their schemas for editors. Opens no port.

    What no option says is asked at a terminal; elsewhere the default stands, which makes a rig of twins.

    Parameters
    ----------
    folder
        Where rig.toml, procedure.toml and their schemas are written; it is made where the folder above it is there.
    name
        Name of the rig.
    gravity_mps2
        Local gravity.
    gravity_source
        Where that figure comes from.
    pitch_port
        Port of the pitch axis.
    roll_port
        Port of the roll axis.
    increment_deg
        Step of the table.
    speed_dps
        Its speed.
    uncertainty_arcsec
        Limit of its index errors.
    meter
        Address of the 3458A.
    sensor
        Serial number of the sensor.
    axes
        Its axes, such as xyz.
    sensitivity_v_per_g
        Its nominal sensitivity.
    usage_deg
        It is used at pitch from minus to plus so much.
    """
    given: dict[str, Any] = {
        "name": name, "gravity_mps2": gravity_mps2, "gravity_source": gravity_source, "pitch_port": pitch_port,
        "roll_port": roll_port, "increment_deg": increment_deg, "speed_dps": speed_dps,
        "uncertainty_arcsec": uncertainty_arcsec, "meter": meter, "sensor": sensor, "axes": axes,
        "sensitivity_v_per_g": sensitivity_v_per_g, "usage_deg": usage_deg,
    }  # fmt: skip
    paths = {file: folder / file for file in ("rig.toml", "procedure.toml", *schemas())}
    _require_room(folder, [path for file, path in paths.items() if file.endswith(".toml")])
    answers = _complete(Answers(**{key: value for key, value in given.items() if value is not None}), given)
    texts = {"rig.toml": rig_text(answers), **schemas()}
    try:
        rig = rig_of(TomlFile(paths["rig.toml"], texts["rig.toml"]))
    except DescriptionError as error:
        raise RequestError(_by_option(str(error))) from error
    texts["procedure.toml"] = first_procedure(answers, rig)
    report = check(rig, procedure_of(TomlFile(paths["procedure.toml"], texts["procedure.toml"])))
    folder.mkdir(exist_ok=True)
    for file, path in paths.items():
        write_whole(path, texts[file].encode("utf-8"))
    say(f"written: {', '.join(map(str, paths.values()))}")
    say(f"{len(report.plan.design_dwells)} dwells, about {duration(report.plan.expected.p50_s)}; next:")
    say(f"calrig check {paths['procedure.toml']} --rig {paths['rig.toml']}")


def _require_room(folder: Path, files: Sequence[Path]) -> None:
    """Refuse a folder that cannot be written into, or that holds one of the files. Raises: RequestError."""
    there = [str(file) for file in files if file.exists()]
    if there:
        what = f"{', '.join(there)}: there already"
    elif folder.exists() and not folder.is_dir():
        what = f"{folder}: is a file"
    elif not folder.parent.is_dir():
        what = f"{folder.parent}: no folder is there"
    else:
        return
    raise RequestError(f"new: {what}; nothing was written; give another folder")


def _complete(answers: Answers, given: Mapping[str, Any]) -> Answers:
    """Return the answers, those that are missing asked for at a terminal. Raises: RequestError for what cannot be."""
    if sys.stdin.isatty():
        for item in fields(Answers):
            if given[item.name] is None:
                answers = replace(answers, **{item.name: _answer_to(item.name, getattr(answers, item.name))})
    if not set(answers.axes) <= set("xyz") or len(set(answers.axes)) != len(answers.axes) or not answers.axes:
        raise RequestError(f"new: --axes: got {answers.axes!r}, allowed are x, y, z and several of them, such as xyz")
    if not 0.0 < answers.usage_deg <= 90.0:
        raise RequestError(f"new: --usage-deg: got {answers.usage_deg:g}, allowed above 0 to 90")
    if not answers.sensor.replace("-", "").replace("_", "").isalnum():
        raise RequestError(f"new: --sensor: got {answers.sensor!r}, allowed are letters, digits, - and _")
    return answers


def _by_option(complaints: str) -> str:
    """Return what a rig file that nobody has yet was refused for, by the options that it was made of."""
    options = "|".join(item.name for item in fields(Answers))
    named = re.sub(rf"^.*?:\d+: (?:\S+\.)?({options}): ", r"\1: ", complaints, flags=re.MULTILINE)
    lines = [
        f"--{key.replace('_', '-')}: {rest}" if rest else key
        for key, _, rest in (line.partition(": ") for line in named.splitlines())
    ]
    return f"new: {'; '.join(dict.fromkeys(lines))}; nothing was written"


def _answer_to(name: str, default: Any) -> Any:
    """Ask until the answer is of the kind of the default; an empty one is the default."""
    while True:
        answer = input(f"{QUESTIONS[name]} [{default}]: ").strip()
        if not answer:
            return default
        try:
            return type(default)(answer)
        except ValueError:
            say(f"a number is needed, such as {default}")
