"""The twin's laboratory: rig and procedure files of a campaign, carried out by the engine or read from its world.

``through_engine`` runs the plan as a user's run: bytes, settling, judging, journal. ``from_world`` walks the same plan
and asks the same physical world for the same readings, without the bytes between; both see the same noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tp_study.settings import Truth

from ams.observations import Observations
from procedures.journal.header import make_header
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell
from procedures.run.begin import begin
from procedures.run.judgement.history import replications_before
from procedures.solution.observations import observations_of
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.twins.physics.world import World

FloatArray = NDArray[np.float64]

SENSITIVITY_V_PER_G = 2.5
VOLTS = SENSITIVITY_V_PER_G * float(np.deg2rad(1e-4))
"""Volts of 1e-4 degrees."""
TEETH_ARCSEC = 0.1
REFERENCE_DEGC = 20.0
PROBE_NOISE_DEGC = 0.005
SEED = 1999
_LATER_S = 1e6
"""Rig seconds between dwells in the world: longer than any way."""


@dataclass(frozen=True)
class Temperature:
    """Air that warms from replication to replication, and what one sensor makes of it."""

    degc_per_replication: float
    offset_per_degc: float
    """1e-4 degrees per °C."""
    sensitivity_per_degc: float
    """1e-4 degrees at one g per °C."""


@dataclass(frozen=True)
class Campaign:
    """One of TP's calibrations."""

    name: str
    sensors: Mapping[str, Mapping[str, Truth]]
    """Serial to axis to truth."""
    design: str
    """The ``[design]`` table of the procedure file."""
    replications: int
    with_roll: bool = True
    temperature: Mapping[str, Temperature] | None = None
    """By serial; the others do not feel it."""
    teeth_arcsec: float = TEETH_ARCSEC
    samples: int = 4
    seed: int = SEED


@dataclass(frozen=True)
class Bench:
    """The files of a campaign, read and planned."""

    campaign: Campaign
    rig_file: Path
    procedure_file: Path
    rig: RigDescription
    plan: Plan


def prepare(campaign: Campaign, folder: Path) -> Bench:
    """Write the rig and procedure files of a campaign and plan it as ``calrig run`` would."""
    rig_file, procedure_file = folder / f"{campaign.name}-rig.toml", folder / f"{campaign.name}-procedure.toml"
    rig_file.write_text(_rig_text(campaign), encoding="utf-8")
    procedure_file.write_text(_procedure_text(campaign), encoding="utf-8")
    rig = read_rig(rig_file)
    return Bench(campaign, rig_file, procedure_file, rig, make_plan(rig, read_procedure(procedure_file)))


def through_engine(bench: Bench, folder: Path) -> Mapping[str, Observations]:
    """Serial to observations, by a whole run on twins in memory."""
    run_dir = folder / f"{bench.campaign.name}-run"
    run_dir.mkdir()
    header = make_header(
        run_dir.name, bench.plan, bench.rig, bench.rig_file, bench.procedure_file, "study", datetime.now(UTC)
    )
    with open_rig(bench.rig) as rig:
        begin(run_dir, header, bench.plan, rig)
    with JournalReader.open(run_dir) as reader:
        dwells = list(reader.dwells())
    return {
        serial: observations_of(dwells, {str(axis): channel for axis, channel in sensor.channels.items()})
        for serial, sensor in bench.rig.sensors.items()
    }


def from_world(bench: Bench) -> Mapping[str, Observations]:
    """Serial to observations, straight from the world behind the twins."""
    world, done = World(bench.rig), replications_before(bench.plan)
    steps = [step for step in bench.plan.steps if isinstance(step, Dwell) and step.purpose == "design"]
    channels = bench.plan.channels
    means, warmth = np.empty((len(steps), len(channels))), np.full(len(steps), REFERENCE_DEGC)
    for row, step in enumerate(steps):
        now_s = row * _LATER_S
        for axis, target_deg in step.targets_deg.items():
            world.rotate(axis, target_deg, now_s - _LATER_S)
        world.announce(step.step, "read", 1, done[step.step])
        for column, channel in enumerate(channels):
            means[row, column] = np.mean([world.read_voltage_v(channel, now_s) for _ in range(bench.campaign.samples)])
        if world.air:
            warmth[row] = world.read_temperature_degc("air", now_s)
    outputs = dict(zip(channels, means.T, strict=True))
    return {
        serial: Observations(
            replication=np.array([step.replication for step in steps]),
            point=np.array([step.point for step in steps]),
            pitch_rad=np.deg2rad([step.targets_deg["pitch"] for step in steps]),
            roll_rad=np.deg2rad([step.targets_deg.get("roll", 0.0) for step in steps]),
            outputs={axis: outputs[channel] for axis, channel in sensor.channels.items()},
            temperature_degc=warmth if world.air else None,
            source=bench.campaign.name,
        )
        for serial, sensor in bench.rig.sensors.items()
    }


def _rig_text(campaign: Campaign) -> str:
    axes = ("pitch", "roll") if campaign.with_roll else ("pitch",)
    lines = ['[rig]\nname = "the laboratory of TP"\ngravity_mps2 = 9.79826']
    lines += [_AXIS.format(name=name, number=index, teeth=campaign.teeth_arcsec) for index, name in enumerate(axes, 1)]
    channels = [(serial, axis) for serial, truths in campaign.sensors.items() for axis in truths]
    scanned = ", ".join(
        f"{_channel(*pair)} = {{ scanner = {index}, range_v = 10.0 }}" for index, pair in enumerate(channels, 1)
    )
    lines.append(f'[readouts.dmm]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 10\nchannels = {{ {scanned} }}')
    if campaign.temperature:
        lines.append('[environment.air]\ndriver = "watlow-f4"\nport = "twin"')
    lines += [_sensor_text(serial, truths) for serial, truths in campaign.sensors.items()]
    lines.append(f"[twin]\nseed = {campaign.seed}")
    if campaign.temperature:
        drift = next(iter(campaign.temperature.values())).degc_per_replication
        lines.append(
            f"[twin.environment.air]\ntemperature_degc = {REFERENCE_DEGC}\nnoise_degc = {PROBE_NOISE_DEGC}\n"
            f"drift_degc_per_replication = {drift}"
        )
    for serial, axis in channels:
        feeling = (campaign.temperature or {}).get(serial)
        lines.append(_truth_text(serial, axis, campaign.sensors[serial][axis], campaign.samples, feeling))
    return "\n".join(lines) + "\n"


_AXIS = """[axes.{name}]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 5.0
uncertainty_arcsec = {teeth}
axis = {number}"""


def _channel(serial: str, axis: str) -> str:
    return f"{serial.lower()}{axis}"


def _sensor_text(serial: str, truths: Mapping[str, Truth]) -> str:
    kind = {1: "single-axis", 3: "three-axis"}[len(truths)]
    channels = ", ".join(f'{axis} = "dmm.{_channel(serial, axis)}"' for axis in truths)
    return (
        f'[sensors.{serial}]\nmodel = "{kind} package"\nchannels = {{ {channels} }}\n'
        f"nominal_sensitivity_v_per_g = {SENSITIVITY_V_PER_G}"
    )


def _truth_text(serial: str, axis: str, truth: Truth, samples: int, feeling: Temperature | None) -> str:
    warm = (feeling.offset_per_degc, feeling.sensitivity_per_degc) if feeling else (0.0, 0.0)
    relative = float(np.deg2rad(1e-4))
    return (
        f"[twin.truth.{serial}.{axis}]\noffset_v = 0.005\nsensitivity_v_per_g = {SENSITIVITY_V_PER_G}\n"
        f"coning_deg = 0.5\nazimuth_deg = 35.0\nnoise_v = {truth.noise * VOLTS * samples**0.5!r}\n"
        f"offset_drift_v_per_replication = {truth.offset_drift * VOLTS!r}\n"
        f"sensitivity_drift_per_replication = {truth.sensitivity_drift * relative!r}\n"
        f"offset_tc_v_per_degc = {warm[0] * VOLTS!r}\nsensitivity_tc_per_degc = {warm[1] * relative!r}\n"
        f"reference_temperature_degc = {REFERENCE_DEGC}\nq_v_per_g2 = {[value * VOLTS for value in truth.q]!r}"
    )


def _procedure_text(campaign: Campaign) -> str:
    tumble = 'kind = "T"' in campaign.design
    model = "pitch-roll" if campaign.with_roll else "pitch-only"
    return (
        f'[procedure]\ntitle = "{campaign.name}"\nkind = "{"tumble" if tumble else "grid"}"\n'
        f"replications = {campaign.replications}\n[design]\n{campaign.design}\n"
        f'[dwell]\nsamples = {campaign.samples}\n[solve]\nmodel = "{model}"\n'
    )
