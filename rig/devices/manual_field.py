"""A field that the operator applies: a coil on a bench supply, a magnet that is put in its holder and taken away.

Each step is said in one line and answered with Enter or with ``no``. Before the first answer nobody knows the field.
"""

import math
from typing import Literal

from rig.abilities.abilities import FieldState
from rig.description.device_settings import FieldSettings
from rig.devices.manual import Prompt
from rig.errors import RequestRefused
from rig.link.byte_stream import ByteStream
from rig.wire import manual as wire
from rig.wire.manual import ApplyField, LeaveIt


class ManualFieldSettings(FieldSettings):
    """``driver = "manual"``; port ``terminal`` prompts where the command runs."""

    driver: Literal["manual"]


class ManualField:
    """A :class:`rig.abilities.abilities.Field` whose supply is the operator."""

    def __init__(self, name: str, settings: FieldSettings, prompt: Prompt) -> None:
        self.name = name
        self.limits_ut = settings.limits_ut
        self._prompt = prompt
        self._pending_ut: float | None = None
        self._applied_ut: float | None = None
        self._fault = ""

    def identify(self) -> str:
        return f"{self.name}, applied by the operator"

    def check_field(self, field_ut: float) -> None:
        low, high = self.limits_ut
        if not (math.isfinite(field_ut) and low <= field_ut <= high):
            raise RequestRefused(
                f"{self.name}: apply {field_ut:g} µT: allowed {low:g} to {high:g} µT (field.{self.name}: limits_ut);"
                " nothing was asked; ask for a field inside"
            )

    def start_field(self, field_ut: float) -> None:
        """Ask the operator. Raises also: RequestRefused while another question is open."""
        self.check_field(field_ut)
        if not self._prompt.is_free:
            raise RequestRefused(
                f"{self.name}: the operator is asked something else; nothing more was asked; wait for the answer"
            )
        self._applied_ut, self._fault = None, ""
        self._prompt.ask(ApplyField(self.name, round(field_ut, 6)))
        self._pending_ut = field_ut

    def state(self) -> FieldState:
        answer = self._prompt.answer() if self._pending_ut is not None else None
        if self._pending_ut is not None and answer is not None:
            ordered_ut, self._pending_ut = self._pending_ut, None
            if answer.lower() == wire.CANNOT:
                self._fault = "the operator could not apply the field"
            elif answer:
                self.start_field(ordered_ut)  # not understood: a person reads the line again
            else:
                self._applied_ut = ordered_ut
        return FieldState(self._applied_ut, self._fault, awaits_operator=self._pending_ut is not None)

    def stop(self) -> None:
        if self._pending_ut is not None:
            self._pending_ut = None
            self._prompt.tell(LeaveIt(self.name))


def connect(name: str, settings: FieldSettings, stream: ByteStream) -> ManualField:
    """Return the field that one operator applies."""
    return ManualField(name, settings, Prompt(stream))
