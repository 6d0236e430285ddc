"""The laboratory of the study of hours: one package or eight on a table whose errors are smooth, everything on twins.

What is there to be found: a table within its certificate's limit of one arc second but smooth, with teeth of a tenth;
a soft mount of one arc second in every package; an offset that drifts by a twentieth of an arc second a replication,
however short the replication is; readings of 20 µV (1.65 arc seconds).
"""

from math import pi

ARCSEC = pi / 180.0 / 3600.0
V_PER_G = 2.5
NOISE_V = 2e-5
LIMIT_ARCSEC = 1.0
TEETH_ARCSEC = 0.1
SOFT_ARCSEC = 1.0
DRIFT_ARCSEC = 0.05
HARMONICS = {"pitch": ((1, 0.5, 40.0), (2, 0.35, 110.0)), "roll": ((1, 0.45, 200.0), (3, 0.3, 15.0))}
"""Times a turn, amplitude in arc seconds, phase in degrees: within the limit together with the teeth."""
SIGNS = {"x": 1.0, "y": -1.0, "z": -1.0}

_AXIS = """[axes.{name}]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 5.0
uncertainty_arcsec = {limit}
axis = {number}
{more}
[twin.axes.{name}]
index_error_arcsec = {teeth}
index_harmonics = {harmonics}
"""


def rig_text(packages: int, seed: int, together: str = "") -> str:
    """Return the rig file; ``together``: lines for every axis."""
    serials = [f"SN{number:02d}" for number in range(1, packages + 1)]
    lines = ['[rig]\nname = "laboratory of the study of hours"\ngravity_mps2 = 9.79826']
    for number, (name, harmonics) in enumerate(HARMONICS.items(), start=1):
        waves = [list(wave) for wave in harmonics]
        lines.append(
            _AXIS.format(
                name=name, number=number, limit=LIMIT_ARCSEC, teeth=TEETH_ARCSEC, harmonics=waves, more=together
            )
        )
    channels = [f"{serial.lower()}{axis}" for serial in serials for axis in "xyz"]
    scanned = ", ".join(
        f"{name} = {{ scanner = {100 * (1 + place // 10) + place % 10}, range_v = 10.0 }}"
        for place, name in enumerate(channels)
    )
    lines.append(f'[readouts.dmm]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 10\nchannels = {{ {scanned} }}')
    lines.append(f'[twin]\nseed = {seed}\ntime = "virtual"')
    for place, serial in enumerate(serials):
        wired = ", ".join(f'{axis} = "dmm.{serial.lower()}{axis}"' for axis in "xyz")
        lines.append(
            f'[sensors.{serial}]\nmodel = "three-axis package"\nchannels = {{ {wired} }}\n'
            f"nominal_sensitivity_v_per_g = {V_PER_G}"
        )
        soft = [SOFT_ARCSEC * ARCSEC * V_PER_G * part for part in (0.6, -0.4, 0.5, 0.3, -0.5)]
        for axis in "xyz":
            lines.append(
                f"[twin.truth.{serial}.{axis}]\noffset_v = {0.005 + 0.001 * place}\nsensitivity_v_per_g = {V_PER_G}\n"
                f"coning_deg = 0.4\nazimuth_deg = {35.0 + 10.0 * place}\nnoise_v = {NOISE_V}\n"
                f"offset_drift_v_per_replication = {DRIFT_ARCSEC * ARCSEC * V_PER_G!r}\nq_v_per_g2 = {soft!r}"
            )
    return "\n".join(lines) + "\n"
