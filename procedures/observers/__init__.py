"""Who else is told what a run tells: observers by entry point, calrig's own and those of other distributions."""
