"""Every kind of run; a new one is a file beside these and a line here."""

from collections.abc import Mapping

from procedures.kinds.grid import Grid
from procedures.kinds.kind import Kind
from procedures.kinds.profile import ProfileMotion
from procedures.kinds.rates import ConstantRates
from procedures.kinds.static import LongRest
from procedures.kinds.tumble import Tumble
from procedures.kinds.two_level import TwoLevel

_ALL: tuple[Kind, ...] = (Grid(), Tumble(), ConstantRates(), ProfileMotion(), TwoLevel(), LongRest())
KINDS: Mapping[str, Kind] = {kind.name: kind for kind in _ALL}
"""By the name that ``procedure.kind`` has."""
