"""The coefficient set: a calibration and its provenance as one sealed document.

The document (plain JSON values) is the set; :class:`CoefficientSet` holds it with the numbers that evaluation needs
already read out. A set is built once, from a solved calibration, and from then on only read.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from html import escape

from ams.calibration_result import METHOD_VERSION, Calibration
from ams.errors import SetError, SetWithdrawn
from ams.gravity import Gravity
from ams.sets.axis_section import axis_numbers, axis_section
from ams.sets.canonical import Document, Json, listed, number, plain, render, table, with_checksum
from ams.sets.equations import CONVENTIONS, AxisNumbers, are_lines, check_numbers
from ams.sets.instructions import use_section
from ams.sets.package_section import package_section
from ams.sets.provenance import Provenance, origin_sections, record_sections
from ams.sets.schema import FORMAT, VERSION, check_identity, check_schema
from ams.sets.sensed_quantity import FIELDS
from ams.sets.signature import Signature
from ams.sets.stated_verdict import (
    NOT_USABLE,
    AcceptedVerdict,
    Withdrawal,
    standing_in_words,
    stated_verdict,
    unsigned_status,
    verdict_in_words,
)
from ams.sets.triad_section import check_triad, triad_section
from ams.sets.vectors import LEVEL, Validity, VectorAgreement, check_vectors, make_vectors, outputs_key
from ams.sets.verdict_conditions import NO_TEMPERATURE


@dataclass(frozen=True)
class CoefficientSet:
    """A sealed document, checked, with its numbers at hand. Treat the document as read-only."""

    document: Document = field(repr=False)
    axes: Mapping[str, AxisNumbers] = field(repr=False)
    validity: Validity = field(repr=False)
    is_built: bool = field(default=False, compare=False)
    """Made here and not read: its schema is checked when it first leaves, which takes longer than to solve it."""
    signatures: tuple[Signature, ...] = field(default=(), compare=False)
    """Who signed it, in this order, as the archive that hands it out knows; the document stays as it was sealed."""
    accepted_verdict: AcceptedVerdict | None = field(default=None, compare=False)
    """Who accepted that the calibration is not usable, as the archive knows; None where nobody did or had to."""

    withdrawal: Withdrawal | None = field(default=None, compare=False)
    """Who withdrew it, when and why, as the archive knows; None where nobody did."""

    def __repr__(self) -> str:
        axes = ", ".join(self.axes)
        return f"CoefficientSet({self.sensor}: {self.model}, axes {axes}, {self.standing}, sha256 {self.sha256[:12]})"

    @property
    def sensor(self) -> str:
        return str(self._section("sensor")["name"])

    @property
    def sha256(self) -> str:
        """The checksum: what identifies the set."""
        return str(self._section("checksum")["sha256"])

    @property
    def convention(self) -> str:
        return str(self._section("convention")["name"])

    @property
    def model(self) -> str:
        return str(self.document["model"])

    @property
    def status(self) -> str:
        """``engineering``, ``approved`` or ``withdrawn``; not usable, nothing but a signature over it approves it."""
        if self.withdrawal is not None:
            return "withdrawn"
        if self.approved_by:
            return "approved"
        return unsigned_status(str(self.document["status"]), self.verdict)

    @property
    def approved_by(self) -> str | None:
        """Who approved it: by signature, or rig and procedure in the rig file; None where nobody did.

        Who approved the rig said nothing of a calibration that is not usable; withdrawn, it is approved by nobody.
        """
        if self.withdrawal is not None:
            return None
        declared = None if self.verdict == NOT_USABLE else self.document["approved_by"]
        if self.approval is not None:
            return self.approval.name
        return str(declared) if declared else None

    @property
    def approval(self) -> Signature | None:
        """The signature that approves it; None where nobody gave it, or the set was withdrawn since."""
        if self.withdrawal is not None:
            return None
        return next((signature for signature in self.signatures if signature.role == "approved"), None)

    @property
    def verdict(self) -> str | None:
        """``sound``, ``usable`` or ``not usable``; None where a set of an earlier version tells none."""
        return stated_verdict(self.document)

    @property
    def doubt(self) -> str | None:
        """What a user must know: that it is withdrawn, or not usable, why, and who accepted that; else None."""
        if self.withdrawal is not None:
            return f"{self.sensor}: set {self.sha256[:12]} is {self.withdrawal}: it must not be used"
        if self.verdict != NOT_USABLE:
            return None
        word = self.accepted_verdict
        accepted = "" if word is None else f"; accepted by {word.name}: {word.reason}"
        return f"{self.sensor}: verdict of the calibration: {verdict_in_words(self.document)}{accepted}"

    @property
    def standing(self) -> str:
        """The status in words: by whom it was withdrawn and why, or who accepted an approval over not usable."""
        if self.withdrawal is not None:
            return str(self.withdrawal)
        return standing_in_words(self.status, self.verdict, self.accepted_verdict)

    @property
    def gravity_mps2(self) -> float:
        """The local g of the calibration: its unit of acceleration."""
        return self.gravity.value_mps2

    @property
    def gravity(self) -> Gravity:
        """The local g of the calibration with what was declared of it."""
        unit = self._section("acceleration_unit")
        return Gravity(
            number(unit["value_mps2"]), number(unit.get("standard_uncertainty_mps2", 0.0)), str(unit["source"])
        )

    @property
    def senses_gravity(self) -> bool:
        """Whether coefficients are per local g: those of gyros and of fields hold at every g."""
        return any(numbers.form.unit == "g" for numbers in self.axes.values())

    @property
    def is_temperature_recorded(self) -> bool:
        """Whether a temperature was recorded with the readings; sets of before the key tell it by remark and range."""
        stated = self.document.get("temperature_recorded")
        if stated is not None:
            return bool(stated)
        remarks = listed(self.document.get("remarks", []))
        is_remarked = any(str(remark).startswith(NO_TEMPERATURE) for remark in remarks)
        return self.validity.temperature_degc is not None and not is_remarked

    @property
    def is_simulated(self) -> bool:
        return bool(self.document["simulated"])

    @property
    def created_utc(self) -> datetime:
        return datetime.fromisoformat(str(self.provenance["created_utc"]))

    @property
    def provenance(self) -> Document:
        return self._section("provenance")

    @property
    def test_vectors(self) -> Document:
        return self._section("test_vectors")

    @property
    def is_of_lines(self) -> bool:
        """Whether every axis is a straight line."""
        return are_lines(self.axes)

    @property
    def needs_temperature(self) -> bool:
        return any(numbers.needs_temperature for numbers in self.axes.values())

    @cached_property
    def rendered(self) -> bytes:
        """The document as the bytes that leave, of the shape that the schema allows. Raises: SetError."""
        if self.is_built:
            check_schema(self.document, self.sensor)
        return render(self.document)

    def require_standing(self, where: str, spared: str) -> None:
        """Refuse a set that was withdrawn. ``spared``: what was not done. Raises: SetWithdrawn."""
        if self.withdrawal is not None:
            raise SetWithdrawn(
                f"{where}: set {self.sha256[:12]} of {self.sensor} is {self.withdrawal}; it is not for use and "
                f"{spared}; use another set of the sensor, or calibrate again"
            )

    def check_vectors(self, where: str) -> VectorAgreement:
        """Recompute the test vectors. Raises: VectorsDisagree."""
        check_triad(self.axes, self.document, where)
        return check_vectors(self.axes, self.test_vectors, where)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: whose set it is and its parameters."""
        rows = "".join(
            f"<tr><td>{axis}</td><td>{name}</td><td>{content['value']}</td><td>{content['standard_uncertainty']}</td></tr>"
            for axis, section in table(self.document["axes"]).items()
            for name, value in table(table(section)["parameters"]).items()
            if (content := table(value))
        )
        simulated = ", simulated" if self.is_simulated else ""
        heads = "".join(f"<th>{head}</th>" for head in ("axis", "parameter", "value", "standard uncertainty"))
        heading = f"<p><b>{escape(self.sensor)}</b>: {escape(self.model)}, {escape(self.standing)}{simulated}</p>"
        return f"{heading}<table><tr>{heads}</tr>{rows}</table>"

    def _section(self, name: str) -> Document:
        return table(self.document[name])


def build_set(calibration: Calibration, provenance: Provenance) -> CoefficientSet:
    """Return the sealed set of one sensor package.

    Raises: SetError where the calibration cannot be a set (unknown equation, an undetermined primary parameter,
    temperature terms without a temperature range, an axis whose sensitivity is not told from zero or lies
    along another direction than declared);
    VectorsDisagree where its parameter forms contradict each other.
    """
    for label, text in calibration.unusable_axes.items():
        raise SetError(f"{provenance.sensor}: axis {label}: {text}")
    axes = {name: axis_section(axis, provenance.sensor) for name, axis in calibration.axes.items()}
    numbers = {name: axis_numbers(name, section) for name, section in axes.items()}
    _check_temperature_range(numbers, provenance)
    document: Document = {
        "format": FORMAT,
        "version": VERSION,
        **origin_sections(provenance, calibration.verdict),
        "model": calibration.model,
        "convention": {"name": calibration.convention, "text": CONVENTIONS.get(calibration.convention, "")},
        "inputs": _inputs(numbers),
        "use": use_section(numbers, provenance.mount, provenance.chain, provenance.temperature_conversion),
        "method_version": METHOD_VERSION,
        "axes": dict(axes),
        **({} if calibration.package is None else {"package": package_section(calibration.package)}),
        **triad_section(numbers),
        "test_vectors": make_vectors(numbers, _validity_of(provenance)),
        "verdict": calibration.verdict,
        "warnings": plain((*calibration.warnings, *calibration.remarks), "warnings"),
        "remarks": plain(_remarks(calibration), "remarks"),
        **record_sections(provenance),
    }
    coefficients = _checked(with_checksum(document), provenance.sensor, is_built=True)
    coefficients.check_vectors(provenance.sensor)
    return coefficients


def from_document(value: Json, where: str) -> CoefficientSet:
    """Return a set from its document, every check but the test vectors made.

    Raises: SetError naming ``where`` and what does not hold.
    """
    document = check_identity(value, where)
    check_schema(document, where)
    try:
        return _checked(document, where, is_built=False)
    except (KeyError, TypeError, AttributeError, AssertionError) as error:  # of a shape that only the schema can tell
        raise SetError(
            f"{where}: has not the shape of a set: {type(error).__name__}: {error}; the set is not used; it was not "
            "written by calrig: export it again from the archive"
        ) from error


def _checked(document: Document, where: str, *, is_built: bool) -> CoefficientSet:
    axes = {name: axis_numbers(name, table(section)) for name, section in table(document["axes"]).items()}
    coefficients = CoefficientSet(document, axes, _read_validity(document), is_built)
    needed = {numbers.form.convention for numbers in coefficients.axes.values() if numbers.model in FIELDS}
    if needed and needed != {coefficients.convention}:
        raise SetError(
            f"{where}: convention: does not go with the equations of this set: got {coefficients.convention}, "
            f"{', '.join(coefficients.axes)} by {coefficients.model!r} need {', '.join(sorted(needed))}; "
            "the set is not used; convert it, or use the version of calrig that wrote it"
        )
    for numbers in axes.values():
        check_numbers(numbers, where)
    units = {(numbers.form.measured_unit, numbers.form.unit) for numbers in coefficients.axes.values()}
    if len(units) > 1:
        named = " and ".join(f"{measured} for {unit}" for measured, unit in sorted(units))
        raise SetError(
            f"{where}: axes: read in different units: got {named}, allowed is one unit of all outputs and one of what "
            "they sense; nothing was built; declare the axes as sensors of their own"
        )
    _check_vector_axes(coefficients, where)
    return coefficients


def _check_temperature_range(axes: Mapping[str, AxisNumbers], provenance: Provenance) -> None:
    needing = [name for name, numbers in axes.items() if numbers.needs_temperature]
    if needing and provenance.temperature_range_degc is None:
        raise SetError(
            f"{provenance.sensor}: axis {needing[0]}: has temperature coefficients but no temperature range "
            "to be valid in; nothing was built; give the provenance its temperature_range_degc"
        )


def _remarks(calibration: Calibration) -> tuple[str, ...]:
    """Return those of the warnings, of package and axes, that are no reservation; what is one anywhere is none."""
    axes = calibration.axes.values()
    reservations = {*calibration.warnings, *(text for axis in axes for text in axis.warnings)}
    said = dict.fromkeys((*calibration.remarks, *(text for axis in axes for text in axis.remarks)))
    return tuple(text for text in said if text not in reservations)


def _inputs(axes: Mapping[str, AxisNumbers]) -> Json:
    named = [name for numbers in axes.values() for name in numbers.form.inputs]
    temperature = any(numbers.needs_temperature for numbers in axes.values())
    return [*dict.fromkeys(named), *(["temperature_degc"] if temperature else [])]


def _validity_of(provenance: Provenance) -> Validity:
    return Validity(
        _as_range(provenance.pitch_range_deg),
        _as_range(provenance.roll_range_deg),
        provenance.temperature_range_degc,
        provenance.yaw_range_deg,
        provenance.rate_range_dps,
        provenance.level_ranges,
    )


def _read_validity(document: Document) -> Validity:
    section = table(document["validity"])
    temperature = section["temperature_degc"]
    return Validity(
        _as_range(section["pitch_deg"]),
        _as_range(section["roll_deg"]),
        None if temperature is None else _as_range(temperature),
        _as_range(section["yaw_deg"]) if "yaw_deg" in section else None,
        _as_range(section["rate_dps"]) if "rate_dps" in section else None,
        {name: _as_range(limits) for name, limits in section.items() if name.startswith(LEVEL)},
    )


def _as_range(value: object) -> tuple[float, float]:
    assert isinstance(value, list | tuple), "the schema was checked"
    return float(value[0]), float(value[1])


def _check_vector_axes(coefficients: CoefficientSet, where: str) -> None:
    section = coefficients.test_vectors
    for vector in [*listed(section["forward"]), *listed(section["inverse"])]:
        axes = set(table(table(vector)[outputs_key(coefficients.axes)]))
        if axes != set(coefficients.axes):
            raise SetError(
                f"{where}: test_vectors: are for other axes: got {', '.join(sorted(axes))}, the set has "
                f"{', '.join(coefficients.axes)}; the set is not used; export it again from the archive"
            )
