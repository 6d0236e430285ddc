"""What the sensors of each model sense, as C."""

from ams.models.sensor_model import SetForm
from ams.sets.sensed_quantity import FIELDS


def models_in_c() -> list[str]:
    """Return the models that have a form in C."""
    forms = {name: form for name, form in FIELDS.items() if form.c_field is not None}
    return [name for name, form in forms.items() if form.output is None or form.output.c is not None]


def field_function(prefix: str, form: SetForm) -> list[str]:
    """Return the function ``…_force``: from the inputs of the model, in degrees and degrees a second, to its field."""
    inputs, c_field = form.inputs, form.c_field
    assert c_field is not None, "models without C were refused"
    angles = [name.removesuffix("_deg") for name in inputs if name.endswith("_deg")]
    given = ", ".join(f"double {name}" for name in inputs)
    radians = ", ".join(f"{angle} = {angle}_deg * degree" for angle in angles)
    turned = ["    const double degree = 0.017453292519943295;", f"    const double {radians};"] if angles else []
    return [
        f"static inline void {prefix}_force({given}, double f[3])",
        "{",
        *turned,
        *c_field.strip("\n").split("\n"),
        "}",
    ]
