"""What a laboratory declares when a certificate may be issued; the tests take single things away."""

from datetime import date

from ams.sets.provenance import Standard

LABORATORY = {"name": "Instrument Laboratory", "address": "1 Granite Way, Hampton", "capability_deg": 0.002}
JOB = {"customer": "Tunnel Ltd, 2 Wind Road", "item": "inclinometer package, clean, no damage", "number": "J-7"}
STANDARD = Standard("table", "77", "C-2025-14", date(2027, 1, 31), {"limit_arcsec": 1.0, "kind": "limit"})
LEVEL = {"uncertainty_arcsec": 0.5, "before": {"about_pitch_arcsec": 0.3, "about_roll_arcsec": -0.2}}
RELEASED = {
    "approved_by": "B. Chief",
    "laboratory": LABORATORY,
    "job": JOB,
    "standards": (STANDARD,),
    "level": LEVEL,
}
