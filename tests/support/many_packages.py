"""A bench with as many three-axis packages as asked for, on one data-acquisition unit: files, and how they lie."""

from pathlib import Path

HEAD = """
[rig]
name = "bench of many packages"
gravity_mps2 = 9.80665
[axes.pitch]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 20.0
axis = 1
[axes.roll]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 20.0
axis = 2
[environment.air]
driver = "watlow-f4"
port = "twin"
"""
PROCEDURE = """
[procedure]
title = "many packages, ±60°, two replications"
kind = "grid"
replications = 2
[design]
kind = "D"
pitch_deg = { from = -60.0, to = 60.0, step = 30.0 }
roll_deg = { from = -180.0, to = 120.0, step = 60.0 }
usage_pitch_deg = [-30.0, 30.0]
[dwell]
samples = 5
[environment]
plateaus_degc = [20.0]
soak_s = 60.0
[check]
reference_every = 20
"""


def serial(number: int) -> str:
    return f"SN{1040 + number}"


def rig_text(packages: int, time: str = '"virtual"') -> str:
    """``time``: as the key of ``[twin]``, such as a factor."""
    axes = [(serial(number), axis) for number in range(1, packages + 1) for axis in "xyz"]
    indices = [100 * (1 + n // 20) + 1 + n % 20 for n in range(len(axes))]
    channels = ", ".join(
        f"{name.lower()}{axis} = {{ channel = {location}, range_v = 10.0 }}"
        for (name, axis), location in zip(axes, indices, strict=True)
    )
    meter = '[readouts.daq]\ndriver = "scpi-daq"\nmodel = "34970A"\nresource = "twin"\nnplc = 1.0\n'
    meter += f"channels = {{ {channels} }}\n"
    sensors, truths = [], []
    for number in range(1, packages + 1):
        name = serial(number)
        wired = ", ".join(f'{axis} = "daq.{name.lower()}{axis}"' for axis in "xyz")
        described = f'model = "three-axis package"\nchannels = {{ {wired} }}\nnominal_sensitivity_v_per_g = 2.5\n'
        sensors.append(f"[sensors.{name}]\n{described}")
        truths.append(f"[twin.truth.{name}]\n" + "".join(_truth(number, n, axis) for n, axis in enumerate("xyz")))
    return HEAD + meter + "".join(sensors) + f"[twin]\nseed = 7\ntime = {time}\n" + "".join(truths)


def _truth(number: int, index: int, axis: str) -> str:
    offset_v = 0.001 * (number - 4) + 0.002 * index
    azimuth_deg = (10.0 + 37.0 * number + 20.0 * index) % 360.0 - 180.0
    return (
        f"{axis} = {{ offset_v = {offset_v:.4f}, sensitivity_v_per_g = {2.5 + 0.004 * number}, "
        f"coning_deg = {0.2 + 0.05 * number:.3f}, azimuth_deg = {azimuth_deg}, noise_v = 2e-5 }}\n"
    )


def many_packages(folder: Path, packages: int, time: str = '"virtual"') -> tuple[Path, Path]:
    """Write rig and procedure; their paths."""
    rig, procedure = folder / "rig.toml", folder / "procedure.toml"
    rig.write_text(rig_text(packages, time), encoding="utf-8")
    procedure.write_text(PROCEDURE, encoding="utf-8")
    return rig, procedure
