"""A signature on a set: whose word it is, in which role, and when it was given."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True)
class Signature:
    """One person's word on one set."""

    role: str
    name: str
    signed_utc: datetime
    comment: str
    function: str = ""
    """Of the person in the laboratory, such as "head of the laboratory"; empty where it was not told."""

    @property
    def signatory(self) -> str:
        """Name and function, as a certificate identifies who authorises it (ISO/IEC 17025, 7.8.2.1 o)."""
        return f"{self.name}, {self.function}" if self.function else self.name
