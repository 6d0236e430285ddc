"""The one physical truth behind all twins: attitude, gravity, temperature, sensors, noise.

Independent physics: explicit rotation matrices, no solver of this distribution is imported. 1 g is local gravity.
A reading at rest depends on the attitude, the announced step and its running number, never on time; so a run in
memory, one over real ports and one that was interrupted read the same bits. A creep is the only exception.
"""

import math
from collections.abc import Mapping

import numpy as np

from rig.abilities.targets import nearest_targets_deg
from rig.description.device_settings import AxisSettings
from rig.description.rig_file import (
    AxisTruth,
    AxisTwin,
    RigDescription,
    Sensor,
    Standard,
    TwinEnvironment,
    TwinSection,
    TwinStream,
)
from rig.description.twin_truth import TwinReadout
from rig.twins.physics.chain import ChainTruth
from rig.twins.physics.chance import Announcement, Chance
from rig.twins.physics.geometry import (
    ARCSEC_RAD,
    UP,
    Matrix,
    Vector,
    about_x,
    about_y,
    about_z,
    permutation,
    sensitive_direction,
)
from rig.twins.physics.motion import Air, AxisBody, AxisErrors
from rig.twins.physics.ramp import Path

SIDEREAL_DAY_S = 86_164.1


class SensorTruth:
    """One sensor axis: what it really gives, without noise."""

    def __init__(self, axis: str, truth: AxisTruth, mount: Matrix) -> None:
        self.noise_v = truth.noise
        """In the unit of the channel, V behind a readout."""
        self._truth = truth
        self._mount = mount
        """From stage axes into package axes, the mounting's small rotation included."""
        self._direction = sensitive_direction(axis, math.radians(truth.coning_deg), math.radians(truth.azimuth_deg))
        self._q = _soft_mount(truth.q_v_per_g2)

    def mean_v(self, stage_sensed: Vector, temperature_degc: float | None, replications: float) -> float:
        """Return V = b + S (u·f) + fᵀQf, with f what the sensor senses, in stage axes: g, °/s or µT."""
        truth = self._truth
        warmer_degc = 0.0 if temperature_degc is None else temperature_degc - truth.reference_temperature_degc
        drift_v = truth.offset_drift_v_per_replication * replications
        offset_v = truth.at_zero + truth.offset_tc_v_per_degc * warmer_degc + drift_v
        offset_v += truth.offset_tc2_v_per_degc2 * warmer_degc**2
        sensitivity = (
            truth.per_unit
            * (1.0 + truth.sensitivity_tc_per_degc * warmer_degc + truth.sensitivity_tc2_per_degc2 * warmer_degc**2)
            * (1.0 + truth.sensitivity_drift_per_replication * replications)
        )
        sensed = self._mount @ stage_sensed
        return float(offset_v + sensitivity * (self._direction @ sensed) + sensed @ self._q @ sensed)


class World:
    """Everything the twins share. One thread at a time."""

    def __init__(self, description: RigDescription) -> None:
        twin = description.twin or TwinSection()
        self.chance = self._chance = Chance(twin.seed)
        self._base = twin.base
        self.meters = twin.readouts
        """By the names of the rig file: what their own checks find."""
        self._twin = twin
        self._applied_ut: dict[str, Vector] = {}
        self.axes = {name: _body(name, axis, description, self._chance) for name, axis in description.axes.items()}
        """By the names of the rig file."""
        self._environments = {name: twin.environment.get(name, TwinEnvironment()) for name in description.environment}
        self.air = {
            name: Air(truth.temperature_degc, truth.drift_degc_per_replication)
            for name, truth in self._environments.items()
        }
        self._setpoints_degc = {name: air.setpoint_degc for name, air in self.air.items()}
        self._sensors = _sensors(description.sensors, twin, self._chance)
        self._senses = {
            channel: sensor.measures for sensor in description.sensors.values() for channel in sensor.channels.values()
        }
        self._unrolled = {
            channel
            for sensor in description.sensors.values()
            for channel in sensor.channels.values()
            if not sensor.rolls
        }
        """Channels of sensors on the sting, which roll does not carry."""
        thermometers = (sensor.temperature for sensor in description.sensors.values())
        self._thermometers = {thermometer.channel: thermometer for thermometer in thermometers if thermometer}
        self._chains = ChainTruth(description)
        self.output_ohm = {
            channel: chain.load_resistor_ohm
            for channel, chain in description.chain.items()
            if chain.load_resistor_ohm is not None
        }
        """By channel: a sensor that makes a current has its load resistor for the resistance of its output."""
        self._steady_v: dict[str, float] = {}
        self._last_sensed: tuple[tuple[str, str, bool, float], Vector] | None = None
        self._noise_v = {channel: sensor.noise_v for channel, sensor in self._sensors.items()}

    @property
    def announcement(self) -> Announcement:
        return self._chance.announcement

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None:
        """Start a new place in the run, as :class:`rig.abilities.abilities.TwinChance` asks."""
        self._chance.announce(Announcement(step, phase, attempt, replications))
        self._forget()

    def _forget(self) -> None:
        """Forget what was worked out before: something has changed."""
        self._steady_v.clear()
        self._last_sensed = None

    def rotate(self, axis: str, target_deg: float, start_s: float) -> float:
        """Turn an axis to a table angle; returns the arrival in rig seconds."""
        self._forget()
        return self.axes[axis].rotate(target_deg, start_s)

    def follow(self, axis: str, path: Path) -> float:
        """Turn an axis along a path of table angles, degrees; returns the arrival in rig seconds."""
        self._forget()
        return self.axes[axis].follow(path)

    def stall(self, axis: str, for_s: float) -> None:
        """Let the next move of an axis stand still for so long."""
        self.axes[axis].stall(for_s)

    def slip(self, axis: str, slip_deg: float, now_s: float, *, seen: bool) -> None:
        """Let an axis slip, with or without its read-back."""
        self._forget()
        self.axes[axis].slip(slip_deg, now_s, seen=seen)

    def lag(self, axis: str, lag_s: float) -> None:
        """Let what an axis turns follow its read-back later."""
        self._forget()
        self.axes[axis].lag(lag_s)

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        """Send an environment to a setpoint."""
        self._setpoints_degc[environment] = setpoint_degc
        self.disturb(environment, setpoint_degc, now_s)

    def disturb(self, environment: str, degc: float, now_s: float) -> None:
        """Let the air go elsewhere than its setpoint: an open door, a heater that fails."""
        self._forget()
        self.air[environment].hold(degc, now_s)

    def setpoint_degc(self, environment: str) -> float:
        return self._setpoints_degc[environment]

    def read_voltage_v(self, channel: str, now_s: float) -> float:
        """Take one reading of a channel such as ``dmm.x``; a channel with nothing behind it is a short.

        Counts as a reading: the next call has the next noise.
        """
        mean_v = self._steady_v.get(channel)
        if mean_v is None:
            mean_v = self.mean_v(channel, now_s)
            if now_s >= self._still_from_s():
                self._steady_v[channel] = mean_v
        noise_v = self._noise_v.get(channel, 0.0)
        return mean_v + noise_v * self._chance.normal(channel) if noise_v else mean_v

    def mean_v(self, channel: str, now_s: float) -> float:
        """Return what the channel carries, without noise."""
        replications = self._chance.announcement.replications
        supply_v = self._chains.supply_v(channel, replications)
        if supply_v is not None:
            return supply_v
        air_degc = {name: air.temperature_degc(replications, now_s) for name, air in self.air.items()}
        return self._sensed_v(channel, now_s) * self._chains.factor(channel, replications, air_degc)

    def _sensed_v(self, channel: str, now_s: float) -> float:
        """Return what the sensor itself makes."""
        sensor = self._sensors.get(channel)
        if sensor is not None:
            replications = self._chance.announcement.replications
            return sensor.mean_v(self._sensed(channel, now_s), self._sensor_degc(now_s), replications)
        thermometer = self._thermometers.get(channel)
        degc = self._sensor_degc(now_s)
        if thermometer is not None and degc is not None:
            return (degc - thermometer.offset_degc) / thermometer.slope_degc_per_v
        return 0.0

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        """Take one reading of an environment's own probe."""
        noise_degc = self._environments[environment].noise_degc
        truth_degc = self.air[environment].temperature_degc(self._chance.announcement.replications, now_s)
        return truth_degc + noise_degc * self._chance.normal(f"environment.{environment}")

    def attitude_deg(self, axis: str, now_s: float) -> float:
        """Return the true attitude of an axis, degrees; 0 where the rig has none of that name."""
        return math.degrees(self._angle_rad(axis, now_s))

    def read_attitude_deg(self, readout: str, axis: str, now_s: float) -> float:
        """Take one reading of a meter of angles, degrees."""
        truth = self.meters.get(readout, TwinReadout())
        noise_deg = truth.noise_deg * self._chance.normal(f"angle.{readout}.{axis}") if truth.noise_deg else 0.0
        return self.attitude_deg(axis, now_s) + truth.error_deg + noise_deg

    def stage_force_g(self, now_s: float, *, rolls: bool = True) -> Vector:
        """Return the specific force in the axes of the stage that carries the packages.

        Base, pitch, yaw, roll from outside in; without roll that of the sting.
        """
        angles = {name: body.attitude_rad(now_s) for name, body in self.axes.items()}
        pitch = angles.get("pitch", 0.0)
        pitch -= self._base.droop_arcsec * ARCSEC_RAD * math.cos(pitch)
        yaw = angles.get("yaw", 0.0) + self._base.orthogonality_arcsec * ARCSEC_RAD
        tilt: Matrix = about_y(self._base.tilt_about_pitch_arcsec * ARCSEC_RAD) @ about_x(
            self._base.tilt_about_roll_arcsec * ARCSEC_RAD
        )
        force_g: Vector = about_z(yaw) @ about_y(pitch) @ tilt @ UP
        if rolls:
            force_g = about_x(angles.get("roll", 0.0)) @ force_g
        return force_g

    def stage_rate_dps(self, now_s: float, *, rolls: bool = True) -> Vector:
        """Return the angular velocity of the stage in its own axes: pitch, yaw, roll from outside in."""
        roll, yaw = (self._angle_rad(name, now_s) for name in ("roll", "yaw"))
        pitch_dps, yaw_dps, roll_dps = (
            self.axes[name].attitude_rate_dps(now_s) if name in self.axes else 0.0 for name in ("pitch", "yaw", "roll")
        )
        by_pitch_and_yaw: Vector = about_z(yaw) @ np.array([0.0, pitch_dps, 0.0]) + np.array([0.0, 0.0, yaw_dps])
        if self._base.earth is not None:
            pitch = self._angle_rad("pitch", now_s)
            by_pitch_and_yaw = by_pitch_and_yaw + about_z(yaw) @ about_y(pitch) @ _earth_dps(*self._base.earth)
        if not rolls:
            return by_pitch_and_yaw
        rate_dps: Vector = about_x(roll) @ by_pitch_and_yaw + np.array([roll_dps, 0.0, 0.0])
        return rate_dps

    def stage_field_ut(self, surroundings_ut: Vector, now_s: float, *, rolls: bool = True) -> Vector:
        """Return the magnetic field in stage axes: of the surroundings, in level axes, and what is applied."""
        roll, yaw, pitch = (self._angle_rad(name, now_s) for name in ("roll", "yaw", "pitch"))
        level_ut = sum(self._applied_ut.values(), surroundings_ut)
        turned: Vector = about_z(yaw) @ about_y(pitch) @ level_ut
        if rolls:
            turned = about_x(roll) @ turned
        return turned

    def apply_field(self, name: str, level_ut: Vector) -> None:
        """Switch the field of one coil or magnet, in level axes; zeros take it away."""
        self._forget()
        self._applied_ut[name] = level_ut

    def read_stream(self, channel: str, now_s: float) -> float | None:
        """Take one sample of a streamed sensor, in the unit of the channel; None where no sensor is declared."""
        sensor = self._sensors.get(channel)
        if sensor is None:
            return None
        noise = sensor.noise_v * self._chance.normal(channel) if sensor.noise_v else 0.0
        return self.mean_v(channel, now_s) + noise

    def _sensed(self, channel: str, now_s: float) -> Vector:
        """Return what the sensors of one kind feel at one moment, worked out once."""
        key = (self._senses[channel], channel.partition(".")[0], channel in self._unrolled, now_s)
        if self._last_sensed is None or self._last_sensed[0] != key:
            self._last_sensed = (key, self._sense(channel, now_s))
        return self._last_sensed[1]

    def _sense(self, channel: str, now_s: float) -> Vector:
        rolls = channel not in self._unrolled
        match self._senses[channel]:
            case "rate":
                return self.stage_rate_dps(now_s, rolls=rolls)
            case "field":
                surroundings = self._twin.streams.get(channel.partition(".")[0], TwinStream())
                return self.stage_field_ut(np.array(surroundings.field_ut), now_s, rolls=rolls)
        return self.stage_force_g(now_s, rolls=rolls)

    def _angle_rad(self, axis: str, now_s: float) -> float:
        return self.axes[axis].attitude_rad(now_s) if axis in self.axes else 0.0

    def _sensor_degc(self, now_s: float) -> float | None:
        """Return the temperature of the sensors, which sit in the first environment of the file."""
        for air in self.air.values():
            return air.temperature_degc(self._chance.announcement.replications, now_s)
        return None

    def _still_from_s(self) -> float:
        bodies = max((body.still_from_s for body in self.axes.values()), default=-math.inf)
        return max(bodies, max((air.still_from_s for air in self.air.values()), default=-math.inf))


def _earth_dps(latitude_deg: float, heading_deg: float) -> Vector:
    """Return the Earth's rotation in level axes: x where the table looks, y right of it, z down."""
    rate_dps = 360.0 / SIDEREAL_DAY_S
    latitude, heading = math.radians(latitude_deg), math.radians(heading_deg)
    north = math.cos(latitude)
    return rate_dps * np.array([north * math.cos(heading), -north * math.sin(heading), -math.sin(latitude)])


def _body(name: str, axis: AxisSettings, description: RigDescription, chance: Chance) -> AxisBody:
    truth = (description.twin or TwinSection()).axes.get(name, AxisTwin())
    is_given = bool(truth.index_harmonics or truth.index_list)
    declared_arcsec = 0.0 if is_given else _half_width_arcsec(axis, description.standards)
    errors = AxisErrors(
        index_half_width_arcsec=declared_arcsec if truth.index_error_arcsec is None else truth.index_error_arcsec,
        index_harmonics=truth.index_harmonics,
        index_list=truth.index_list,
        zero_error_arcsec=truth.zero_error_arcsec,
        creep_arcsec=truth.creep_arcsec,
        creep_s=truth.creep_s,
        rate_error=truth.rate_error,
        runaway_after_s=truth.runaway_after_s,
    )
    return AxisBody(
        name,
        chance,
        speed_dps=axis.speed_dps,
        increment_deg=axis.increment_deg,
        sign=axis.sign,
        zero_deg=axis.zero_deg,
        errors=errors,
        stands_deg=_first_stand_deg(axis),
    )


def _first_stand_deg(axis: AxisSettings) -> float:
    """Return the table angle of a twin that nobody moved: its zero; where homing moves nothing, the nearest inside."""
    if axis.moves_to_home or not (nearest_deg := nearest_targets_deg(axis, axis.home_attitude_deg)):
        return 0.0
    return axis.table_deg(min(nearest_deg, key=lambda angle_deg: abs(axis.table_deg(angle_deg))))


def _half_width_arcsec(axis: AxisSettings, standards: Mapping[str, Standard]) -> float:
    """Return the rectangular distribution that has the standard uncertainty which the file declares."""
    standard = standards.get(axis.standard or "")
    if standard is None or standard.kind == "limit":
        return axis.uncertainty_arcsec
    return axis.uncertainty_arcsec * math.sqrt(3.0) / (standard.k if standard.kind == "expanded" else 1.0)


def _sensors(sensors: Mapping[str, Sensor], twin: TwinSection, chance: Chance) -> dict[str, SensorTruth]:
    return {
        channel: SensorTruth(axis, twin.truth[serial][axis], _mounting(serial, sensor, twin, chance))
        for serial, sensor in sensors.items()
        for axis, channel in sensor.channels.items()
    }


def _mounting(serial: str, sensor: Sensor, twin: TwinSection, chance: Chance) -> Matrix:
    """Return the declared mount and the small rotation that this mounting of the package drew."""
    x, y, z = twin.base.remount_arcsec * ARCSEC_RAD * chance.fixed("mounting", serial, twin.mounting).standard_normal(3)
    mount = sensor.mount
    turned: Matrix = about_x(x) @ about_y(y) @ about_z(z) @ permutation(mount.x, mount.y, mount.z)
    return turned


def _soft_mount(q_v_per_g2: tuple[float, float, float, float, float] | None) -> Matrix:
    """Return the traceless symmetric Q from its five terms [xx, xy, xz, yy, yz]."""
    xx, xy, xz, yy, yz = q_v_per_g2 or (0.0, 0.0, 0.0, 0.0, 0.0)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, -xx - yy]])
