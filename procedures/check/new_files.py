"""The first rig file and procedure of a laboratory, from a few answers, with the schemas that complete them."""

import json
from dataclasses import dataclass

from procedures.check.candidate import SearchRange, SearchRequest, Target
from procedures.check.candidate_file import chosen_procedure
from procedures.check.candidates import compare
from procedures.kinds.read import procedure_form
from procedures.solution.expected import Usage
from rig.description.read import rig_form
from rig.description.rig_file import RigDescription
from rig.description.sensor import PACKAGES

RIG_SCHEMA, PROCEDURE_SCHEMA = "rig.schema.json", "procedure.schema.json"
FIRST = SearchRange(grids=((13, 12),), fractions=(), optimal=(), replications=(6,), samples=(10,))
"""A grid that determines every term of a sensor and shows drift and lack of fit; `calrig plan` finds others."""


@dataclass(frozen=True)
class Answers:
    """What is asked, each with what stands for it where nobody answers."""

    name: str = "laboratory"
    gravity_mps2: float = 9.80665
    gravity_source: str = "standard value, not surveyed"
    pitch_port: str = "twin"
    roll_port: str = "twin"
    increment_deg: float = 1.0
    speed_dps: float = 5.0
    uncertainty_arcsec: float = 1.0
    meter: str = "twin"
    sensor: str = "SN1"
    axes: str = "xyz"
    sensitivity_v_per_g: float = 2.5
    usage_deg: float = 60.0


def rig_text(answers: Answers) -> str:
    """Return the rig file: a dual-axis indexing table, a 3458A with its scanner, one package."""
    texts = {key: json.dumps(getattr(answers, key), ensure_ascii=False) for key in Answers.__dataclass_fields__}
    channels = ", ".join(
        f"{axis} = {{ scanner = {index}, range_v = 10.0 }}" for index, axis in enumerate(answers.axes, start=1)
    )
    wired = ", ".join(f'{axis} = "dmm.{axis}"' for axis in answers.axes)
    axes = "\n".join(
        f"[axes.{name}]\n"
        'driver = "indexing-table"\n'
        f"port = {texts[f'{name}_port']}\n"
        f"increment_deg = {answers.increment_deg!r}\n"
        "limits_deg = [-180.0, 180.0]\n"
        f"speed_dps = {answers.speed_dps!r}\n"
        f"uncertainty_arcsec = {answers.uncertainty_arcsec!r}  # a limit, unless a [standards] table says otherwise\n"
        f"axis = {number}\n"
        for number, name in enumerate(("pitch", "roll"), start=1)
    )
    package = next(name for name, count in PACKAGES.items() if count == len(answers.axes))
    is_twin = "twin" in (answers.pitch_port, answers.roll_port, answers.meter)
    return f"""#:schema ./{RIG_SCHEMA}
# Written by calrig new. "twin" is a device that is simulated; replace it by an address (calrig devices lists them).
[rig]
name = {texts["name"]}
gravity_mps2 = {answers.gravity_mps2!r}
gravity_source = {texts["gravity_source"]}
# gravity_uncertainty_mps2 = 0.00001   a standard uncertainty; or latitude_deg and height_m in place of both above

{axes}
[readouts.dmm]
driver = "hp3458a"
resource = {texts["meter"]}
nplc = 10
channels = {{ {channels} }}

[sensors.{answers.sensor}]
model = "{package}"
channels = {{ {wired} }}
nominal_sensitivity_v_per_g = {answers.sensitivity_v_per_g!r}
{_twin(answers) if is_twin else ""}"""


def _twin(answers: Answers) -> str:
    truths = "\n".join(
        f"[twin.truth.{answers.sensor}.{axis}]\n"
        "offset_v = 0.005\n"
        f"sensitivity_v_per_g = {answers.sensitivity_v_per_g!r}\n"
        "coning_deg = 0.4\n"
        f"azimuth_deg = {azimuth}\n"
        f"noise_v = {8e-6 * abs(answers.sensitivity_v_per_g):.3g}\n"
        for axis, azimuth in zip(answers.axes, (35.0, -110.0, 160.0), strict=False)
    )
    comment = "# What the twins really are: remove these tables when no device is a twin any more."
    return f"\n{comment}\n[twin]\nseed = 7\n\n{truths}"


def first_procedure(answers: Answers, rig: RigDescription) -> str:
    """Return the first procedure of the rig. Raises: PlanError where its axes can reach no design."""
    usage = Usage((-answers.usage_deg, answers.usage_deg))
    made_by = f"Written by calrig new for {rig.rig.name}; calrig plan writes one for an accuracy or a number of hours."
    text = chosen_procedure(compare(SearchRequest(rig, Target(hours=1000.0), usage, space=FIRST)), made_by)
    return f"#:schema ./{PROCEDURE_SCHEMA}\n{text}"


def schemas() -> dict[str, str]:
    """Return both schemas by file name, with every driver, kind and design that is installed here."""
    forms = {RIG_SCHEMA: rig_form(), PROCEDURE_SCHEMA: procedure_form()}
    return {
        name: json.dumps(form.model_json_schema(by_alias=True), ensure_ascii=False, indent=1) + "\n"
        for name, form in forms.items()
    }
