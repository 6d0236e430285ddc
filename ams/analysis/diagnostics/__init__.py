"""What the data of a calibration say against the beliefs of its solution: one file a belief; loose is what many share.

All tests of a run are one family (Holm, each axis with its share); dwells that are convicted first are left out of the
others.
"""
