"""What the kinds share that visit a design of attitudes."""

from collections.abc import Iterator

from ams.models.registry import names_at_rest
from procedures.description.described_designs import DESCRIBED_DESIGNS
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.kinds.kind import Key, PlanRequest, Schedule
from procedures.plan.attitudes import environment_of, make_design, plateaus_of, seed_of, steps_at_attitudes
from procedures.plan.order import visits
from procedures.plan.refusals import design_refusals
from rig.toml_file import StrictTable


class AttitudeKind:
    """A kind whose ``[design]`` says everything: packages of accelerometers at rest in its attitudes."""

    table: tuple[str, type[StrictTable]] | None = None
    is_tumble = False
    """Whether its design is one of the few attitudes of a tumble test."""

    @property
    def models(self) -> tuple[str, ...]:
        return names_at_rest()

    def disagreements(self, procedure: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
        if DESCRIBED_DESIGNS[procedure.design.kind].is_tumble is not self.is_tumble:
            if "design" not in procedure.model_fields_set:
                kind = procedure.procedure.kind
                yield ("design",), f"is missing; this is a procedure of kind {kind!r}, which goes to its attitudes"
            else:
                yield (
                    ("design", "kind"),
                    'kind = "tumble" goes with a design of kind "T", and only with it (or "up-down")',
                )

    def measures(self, model: str) -> tuple[str, ...]:
        return ("acceleration",)

    def key_of_angle(self, axis: str) -> Key:
        return "design", f"{axis}_deg"

    def schedule(self, request: PlanRequest) -> Schedule:
        """Return the design in the order asked for, at every plateau. Raises: PlanError for a design that cannot be."""
        procedure = request.procedure
        design = visits(make_design(procedure), procedure.design.order)
        environment = environment_of(request.rig, procedure)
        seed = seed_of(procedure, request.fresh_seed)
        return Schedule(
            design=design,
            steps=tuple(steps_at_attitudes(procedure, design, request.axes, environment, seed)),
            replications=procedure.replications * len(plateaus_of(environment)),
            order=procedure.design.order,
            seed=seed,
            usage_pitch_deg=procedure.design.usage_pitch_deg,
            environment=environment,
            reference=procedure.check,
        )

    def solves_lines(self, model: str, design_kind: str) -> bool:
        return False

    def refusals(self, request: PlanRequest, schedule: Schedule) -> Iterator[PlanError]:
        yield from design_refusals(request.rig, request.procedure, request.sensors, schedule.design)
