"""Coefficient sets: what remains of a calibration, made so that it cannot be applied wrongly unseen.

``coefficients`` builds a set from a calibration and its provenance, ``apply`` evaluates it, ``export`` writes and reads
it in every format of ``export.formats``, ``verify`` reads any export back and recomputes its test vectors, ``archive``
keeps sets.
"""
