"""The certificate as a page, and the page on paper: the same templates and the same typesetter as the report."""

from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, time
from pathlib import Path

from ams.exports.dcc_administration import SPECIMEN
from ams.inputs.shared_errors import G_SENSITIVITY, NONLINEARITY, SHIFTS, SHIFTS_WITHIN
from ams.rounding import to_place
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.capability import capability_deg_of
from ams.sets.coefficients import CoefficientSet
from ams.sets.equipment import equipment_of
from ams.sets.instructions import mount_in_words
from ams.sets.stated_dwells import dwells_in_words, rejected_lines
from ams.sets.stated_findings import (
    DAY_NOT_KNOWN,
    axis_reservations,
    fact_of,
    outside_uncertainty,
    package_reservations,
)
from ams.sets.stated_verdict import conditions_in_words, grounds_in_words
from ams.sets.vectors import LEVEL
from ams.sets.verdict_conditions import NO_METER, NOT_BUDGETED
from ams.surveillance.adjustment import acceptance_of
from ams.units import printed
from procedures.certificate.annex import annex_of
from procedures.certificate.equation import forms_of, meanings_of, method_of, nearest
from procedures.certificate.grounds import Grounds, meters_undeclared, printed_gaps
from procedures.certificate.results import angle_rows, coefficients_of, is_visited_again, undetermined
from procedures.numbers import angle
from procedures.pages import page_style, with_whole_options
from procedures.report.page import STYLE_SHEET, report_environment
from procedures.report.page import TEMPLATES as SHARED_TEMPLATES
from procedures.report.paper.pdf import Attachment, Imprint, paper_of
from procedures.solution.budget_view import FORMS

TEMPLATES = Path(__file__).with_name("templates")
TURN_DEG = 360.0
USED_AT = "temperature of use, "
"""What the names of the parts of U for use at other temperatures than that of the calibration begin with."""
WITHDRAWN = "SET WITHDRAWN"
NOT_USABLE = "CALIBRATION NOT USABLE"
"""Printed on every page, whoever accepted it: a page that is taken out of the paper must say it too."""


def certificate_page(grounds: Grounds) -> str:
    """Return the page of a certificate as HTML."""
    capability_deg = capability_deg_of(grounds.coefficients)
    errors = {} if grounds.adjustment is None else grounds.adjustment.as_left.errors
    judgements = () if grounds.adjustment is None else grounds.adjustment.as_left.judgements
    template = report_environment(TEMPLATES, SHARED_TEMPLATES).get_template("certificate.html.j2")
    page = template.render(
        grounds=grounds,
        one=grounds.coefficients,
        document=grounds.coefficients.document,
        mount=mount_in_words(grounds.coefficients.document),
        coefficients=list(coefficients_of(grounds.coefficients, capability_deg)),
        undetermined=list(undetermined(grounds.coefficients)),
        method=method_of(grounds.coefficients),
        forms=list(forms_of(grounds.coefficients)),
        meanings=meanings_of(grounds.coefficients),
        nearest=nearest(grounds.coefficients),
        angles=list(angle_rows(errors, judgements, capability_deg)),
        again=is_visited_again(errors),
        lines=grounds.coefficients.is_of_lines,
        readings=table(grounds.coefficients.provenance.get("readings") or {}),
        limits=acceptance_of(grounds.coefficients.provenance).limits_deg,
        capability=None if capability_deg is None else f"{capability_deg:g}",
        gaps=list(printed_gaps(grounds)) if grounds.is_specimen else [],
        equipment=equipment_of(grounds.coefficients),
        annex=list(annex_of(grounds.coefficients)),
        budget_forms=FORMS,
        dwells=_dwells(grounds),
        rejected=rejected_lines(grounds.coefficients.document),
        verdict_conditions=conditions_in_words(grounds.coefficients.document),
        meters=[said.fact for said in meters_undeclared(grounds) if said.fact.startswith(NO_METER)],
        conditions=_conditions(grounds.coefficients),
        order=_order(grounds),
        shift=_shift_in_words(grounds.coefficients),
        reservations=_reservations(grounds),
        not_budgeted=_sentence(NOT_BUDGETED) if grounds.coefficients.senses_gravity else "",
        lacking=_facts(grounds.coefficients.document, outside_uncertainty(grounds.coefficients.document)),
        specimen=SPECIMEN,
        not_usable=NOT_USABLE,
        withdrawn=WITHDRAWN,
        grounds_of_verdict=grounds_in_words(grounds.coefficients.document),
        standing_sentence=_standing_sentence(grounds),
        **page_style(STYLE_SHEET),
    )
    return with_whole_options(page)


def certificate_paper(grounds: Grounds, page: str, attachments: Sequence[Attachment]) -> bytes:
    """Return the PDF/A-3b of a certificate's page."""
    moment = datetime.combine(grounds.issued, time(), tzinfo=UTC)
    stamps = (*((SPECIMEN,) if grounds.is_specimen else ()), *((NOT_USABLE,) if grounds.is_not_usable else ()))
    stamps = (*stamps, *((WITHDRAWN,) if grounds.signed.withdrawal is not None else ()))
    return paper_of(
        page, Imprint(f"Calibration certificate {grounds.number}", stamps, f"Certificate {grounds.number}", moment),
        attachments,
    )  # fmt: skip


def _dwells(grounds: Grounds) -> str:
    """Say how many dwells count; of a withdrawn set as its run stood when it was made."""
    stated = dwells_in_words(grounds.coefficients.document)
    return stated if grounds.signed.withdrawal is None else f"As the run stood when the set was made: {stated}"


def _standing_sentence(grounds: Grounds) -> str:
    """Say where the set stands, in the words of the archive."""
    return f"The set is {grounds.signed.standing.rstrip('.')}."


def _order(grounds: Grounds) -> dict[str, str]:
    """Return who asked for what, where it was done, and when; the day of receipt where it is on record.

    Source: ISO/IEC 17025:2017, 7.8.2.1 c, e, g, h, i, j.
    """
    sensor, received = table(grounds.coefficients.document["sensor"]), grounds.job.get("received")
    return {
        "Customer": str(grounds.job.get("customer") or "not declared"),
        "Customer’s contact": str(grounds.job.get("customer_contact") or "not declared"),
        "Item": str(grounds.job.get("item") or "not declared"),
        "Serial number": str(sensor["serial"] or sensor["name"]),
        "Model": str(sensor["model"] or "not declared"),
        "Order": str(grounds.job.get("number") or "none"),
        **({"Received": str(received)} if received else {}),
        "Calibrated": _calibrated(grounds),
        "Issued": f"{grounds.issued}",
        "Place": str(grounds.job.get("location") or grounds.laboratory.get("address") or "not declared"),
    }


def _conditions(coefficients: CoefficientSet) -> dict[str, str]:
    """Return under which attitudes, temperatures and gravity the results hold."""
    document = coefficients.document
    validity = table(document["validity"])
    ranges = {name: validity.get(f"{name}_deg") for name in ("pitch", "roll", "yaw")}
    attitude_ranges = {
        f"Valid for {name}": _range_in_words(number(listed(ends)[0]), number(listed(ends)[1]))
        for name, ends in ranges.items()
        if ends is not None
    }
    use_degc = validity.get("temperature_degc")
    how = " (declared; none was recorded with the readings)" if not coefficients.is_temperature_recorded else ""
    use = {} if use_degc is None else {"Valid for temperature": f"{_degc_in_words(listed(use_degc))}{how}"}
    air = {
        f"Temperature, {name}": _degc_in_words([table(condition)["min_degc"], table(condition)["max_degc"]])
        for name, condition in table(document["environment"]).items()
    }
    levels = {
        f"{quantity.replace('_', ' ').capitalize()}": f"{to_place(number(low), -3)} to {to_place(number(high), -3)} "
        f"{printed(unit)}"
        for name, (low, high) in ((name, listed(ends)) for name, ends in validity.items() if name.startswith(LEVEL))
        for quantity, unit in [name.rsplit("_", 1)]
    }
    return {
        **(levels or attitude_ranges),
        **use,
        **(air or _of_no_environment(coefficients)),
        "Relative humidity": _humidity(coefficients),
        **_supplies(coefficients),
        "Local gravity": coefficients.gravity.in_words,
    }


def _of_no_environment(coefficients: CoefficientSet) -> dict[str, str]:
    """Say what was measured of the temperature where no environment of the rig told any."""
    if coefficients.is_temperature_recorded:
        return {"Temperature of the sensor": "recorded with the readings", "Temperature around it": "not measured"}
    return {"Temperature": "not measured"}


def _humidity(coefficients: CoefficientSet) -> str:
    """Return the humidity that the laboratory declares of the job."""
    stated = table(coefficients.provenance["job"] or {}).get("relative_humidity_percent")
    return "not recorded" if stated is None else " to ".join(f"{number(end):g}" for end in listed(stated)) + " %"


def _supplies(coefficients: CoefficientSet) -> dict[str, str]:
    """Return between which volts the item was supplied; of a set of before nobody knows whether that was read."""
    stated = coefficients.provenance.get("supplies")
    supplies = {
        f"Supply of the item, {channel}": " to ".join(
            to_place(number(table(volts)[end]), -4).replace("-", "−") for end in ("min_v", "max_v")
        )
        + " V"
        for channel, volts in table(stated or {}).items()
    }
    return supplies or {"Supply of the item": "not stated" if stated is None else "not recorded"}


def _degc_in_words(ends: Sequence[Json]) -> str:
    low, high = (to_place(number(end), -2) for end in ends)
    return f"{low} to {high} °C".replace("-", "−")


def _range_in_words(low_deg: float, high_deg: float) -> str:
    """Say where a set is valid: its design may stop a step before a whole turn is round."""
    ends = f"{angle(low_deg)} to {angle(high_deg)}"
    return f"all round ({ends})" if high_deg - low_deg >= TURN_DEG else ends


def _shift_in_words(coefficients: CoefficientSet) -> str:
    """Say whether U counts what an item does after its calibration, and beside its equation."""
    axes = [table(section) for section in table(coefficients.document["axes"]).values()]
    names = {name for axis in axes for name in table(table(axis["primary"])["components"])}
    counted, within = names & {*SHIFTS}, "during the calibration and " if names & {*SHIFTS_WITHIN} else ""
    bent = " It counts how far a reading may be from the equation, as declared." if NONLINEARITY in names else ""
    used = table(coefficients.document["validity"]).get("temperature_degc")
    if any(name.startswith(USED_AT) for name in names) and used is not None:
        bent += f" It counts use at {_degc_in_words(listed(used))}, as declared."
    if G_SENSITIVITY in names:
        bent += " It counts what gravity does to the zero of a gyro at any attitude of use, as declared."
    if counted:
        of_what = " and ".join(name.rpartition(", ")[2] for name in SHIFTS if name in counted)
        return (
            f"U counts what {of_what} may shift by {within}until the next calibration, as declared for the item.{bent}"
        )
    return f"U is that of the calibration: what the item may shift by afterwards is not in it.{bent}"


def _reservations(grounds: Grounds) -> list[str]:
    """Return what the verdict rests on, but for the findings that stand with who accepted them."""
    document, accepted = grounds.coefficients.document, {word.finding for word in grounds.signed.acceptances}
    shown = {finding.text for finding in grounds.signed.findings if finding.name in accepted}
    of_axes = (
        _sentence(f"Axis {axis}: {fact_of(document, text)}")
        for axis, text in axis_reservations(document)
        if text not in shown
    )
    return [*_facts(document, (text for text in package_reservations(document) if text not in shown)), *of_axes]


def _facts(document: Document, texts: Iterable[str]) -> list[str]:
    """Return texts of a set as sentences for the customer: of a finding what the data showed, not what to do."""
    return [_sentence(fact_of(document, text)) for text in texts]


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:].rstrip('.')}."


def _calibrated(grounds: Grounds) -> str:
    """Return the days of the calibration; of a set that does not know them, what its day is."""
    solved, remarks = grounds.coefficients.created_utc.date(), listed(grounds.coefficients.document.get("remarks", []))
    if any(str(text).startswith(DAY_NOT_KNOWN) for text in remarks):
        return f"on a day that is not known; the readings were solved on {solved}"
    began = _began(grounds)
    return began if began == solved.isoformat() else f"{began} to {solved}"


def _began(grounds: Grounds) -> str:
    """Return the day on which the run began, from its name; the day of its end where it has none."""
    run = str(grounds.coefficients.provenance["run_id"] or "")
    ended = grounds.coefficients.created_utc.date().isoformat()
    return f"{run[:4]}-{run[4:6]}-{run[6:8]}" if run[:8].isdigit() else ended
