"""Every kind of run: calrig's own and those of other distributions, by the entry point ``calrig.kinds``."""

from procedures.errors import RequestError
from procedures.kinds.kind import Kind
from rig.registry import Registry

KINDS: Registry[Kind] = Registry("calrig.kinds", Kind, RequestError)  # type: ignore[type-abstract]  # asked, not made
"""By the name that ``procedure.kind`` has."""
