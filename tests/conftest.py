"""For all tests: how long an example of hypothesis takes is no part of any law. A busy machine fails nothing by it;
what hangs is ended by pytest's own time-out."""

from hypothesis import settings

settings.register_profile("calrig", deadline=None)
settings.load_profile("calrig")
