"""Would a run begin, if it were started now: what refuses it, and what would make its result an engineering one.

The same questions that a run asks before it writes anything, so that they are answered at six in the evening and not
at nine, when somebody wants to go home.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from ams.exports.formats import FORMATS
from ams.exports.optional_libraries import missing_sentence, not_installed
from ams.sets.stated_findings import LACKING
from procedures.errors import ProcedureError
from procedures.journal.location import require_local
from procedures.lease.keeper import look
from procedures.plan.plan import Plan
from procedures.plan.undeclared import undeclared_of_plan
from procedures.records.declared_gaps import (
    NOBODY_APPROVED,
    OF_A_TWIN,
    Declared,
    declared_gaps,
    thermometer_remarks,
)
from procedures.records.overdue_standards import overdue_standards
from procedures.run.readiness import Readiness, days_to_come, readiness
from procedures.run.watch.disk_space import free_bytes, require_room
from rig.assembly.open_rig import real_ports
from rig.assembly.unguarded import unstoppable_axes
from rig.description.rig_file import RigDescription
from rig.lines.lock import is_beyond_this_machine, known_elsewhere_as
from rig.local_time import local_day

_UNGUARDED = (
    "{}: nothing guards against a second computer that reaches this device over the network, and moves it; "
    "let this one alone reach it, or name an archive that all computers share (--archive, CALRIG_ARCHIVE)"
)

HTML_NEEDS = ("matplotlib",)
PDF_NEEDS = ("matplotlib", "typst", "lxml")
"""Of extras; the certificate inside the paper takes the last."""


@dataclass(frozen=True, slots=True)
class Preflight:
    """Lists of sentences."""

    refusals: tuple[str, ...]
    """Why the run would not begin."""
    engineering: tuple[str, ...]
    """What is missing for a calibration; empty where twins are measured, which is none anyway."""
    unguarded: tuple[str, ...] = ()
    """Which axes nobody stops when calrig dies, and what nobody keeps from a second controller."""
    guarded: tuple[str, ...] = ()
    """What a lease keeps from a second computer, and by what."""
    undelivered: tuple[str, ...] = ()
    """What a run would not leave because a library is not installed."""
    certificate: tuple[str, ...] = ()
    """What a certificate of the result would lack, as far as the files tell; empty without a plan."""
    dated_ahead: tuple[str, ...] = ()
    """Which sets of the rig's sensors the archive holds that are dated in the future."""


def preflight(
    rig_file: Path,
    rig: RigDescription,
    plan: Plan | None,
    out: Path,
    now: datetime,
    free: Callable[[Path], int] = free_bytes,
    archive_url: str | None = None,
) -> Preflight:
    """``out``: where run folders are made; it need not exist. ``plan``: None where only the rig is looked at.

    ``archive_url``: that keeps the leases of devices that other computers reach; None where none is named.
    Raises: DescriptionError where a driver's axis is not whole.
    """
    ready = readiness(rig, local_day(now))
    checks: list[Callable[[], None]] = [lambda: require_local(out)]
    if not rig.is_simulated:
        checks.append(lambda: ready.require(str(rig_file)))
    if plan is not None:
        planned, most_mb = plan, rig.interlocks.min_free_mb
        checks.append(lambda: require_room(out, planned, free(_nearest(out)), most_mb))
    beyond = [port for port in real_ports(rig) if is_beyond_this_machine(port)]
    looked = look(archive_url, known_elsewhere_as(beyond)) if archive_url is not None and beyond else None
    reached = tuple(map(_UNGUARDED.format, beyond)) if looked is None else looked.unguarded
    unguarded = (*unstoppable_axes(rig.axes), *reached)
    guarded = () if looked is None else looked.guarded
    engineering = () if rig.is_simulated else ready.missing
    undelivered = () if plan is None else tuple(_undelivered(plan))
    refusals = (*_refused(checks), *(() if looked is None else looked.refusals))
    certificate = () if plan is None else tuple(_gaps(rig, plan, ready, now))
    return Preflight(refusals, engineering, unguarded, guarded, undelivered, certificate)


def _gaps(rig: RigDescription, plan: Plan, ready: Readiness, now: datetime) -> Iterator[str]:
    """Yield what :mod:`procedures.certificate.grounds` will miss, whatever is measured."""
    if rig.is_simulated:
        yield OF_A_TWIN
        yield from days_to_come(rig, local_day(now))
        yield from overdue_standards(rig, local_day(now))
    yield f"{NOBODY_APPROVED} (calrig archive sign, when it is archived)"
    undeclared = undeclared_of_plan(rig, plan)
    senses_gravity = any(sensor.measures == "acceleration" for sensor in plan.sensors.values())
    declared = declared_gaps(
        Declared(
            laboratory=rig.laboratory.model_dump() if rig.laboratory else {},
            job=rig.job.model_dump(),
            level=rig.level.model_dump(),
            has_standards=bool(rig.standards),
            senses_gravity=senses_gravity,
            references=(
                *(() if senses_gravity else undeclared.level),
                *undeclared.references,
                *thermometer_remarks(rig, plan.sensors.values(), plan.solve.temperature),
            ),
        )
    )
    yield from (gap.text for gap in declared)
    if not rig.is_simulated:
        yield from (f"{LACKING}{lack}" for lack in ready.missing if not lack.startswith("approved_by"))
    today, ends = local_day(now), local_day(now + timedelta(seconds=plan.expected.p90_s))
    for name, standard in rig.standards.items():
        if today <= standard.due < ends:
            yield f"standards.{name}.due: {standard.due} is its last day, and the run may end after it (p90: on {ends})"


def _undelivered(plan: Plan) -> Iterator[str]:
    wanted = {"report.html": HTML_NEEDS, "report.pdf": PDF_NEEDS}
    wanted |= {f"export {name}": FORMATS[name].needs for name in plan.export_formats if name in FORMATS}
    for what, libraries in wanted.items():
        for name in not_installed(libraries):
            yield f"{what}: {missing_sentence(name)}"


def _refused(checks: list[Callable[[], None]]) -> Iterator[str]:
    for check in checks:
        try:
            check()
        except ProcedureError as error:
            yield str(error)


def _nearest(folder: Path) -> Path:
    """Return the innermost folder that is there."""
    folder = folder.resolve()
    return next(parent for parent in (folder, *folder.parents) if parent.exists())
