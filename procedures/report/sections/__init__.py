"""The sections of a run's page, one file a section with its fragment of a template beside it."""
