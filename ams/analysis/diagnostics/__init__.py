"""What the data of a calibration say against the beliefs of its solution: one file a belief.

All tests of an axis are corrected together (Holm); dwells that are convicted first are left out of the others.
"""
