"""From rig and procedure to the ordered steps of a run: designs, orders, steps, durations, refusals."""
