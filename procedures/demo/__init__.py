"""The rig and the procedure of `calrig demo`."""
