"""Scenes of the sensor: what a real accelerometer does beside offset and sensitivity.

Sizes in µg/g² and the like are against 1 g; a dwell's noise of 1.65″ is 8 µg. Notation: IEEE Std 1293, MATH 10.
"""

from dataclasses import replace

import numpy as np

from physics_scenes.package import coned_vectors, mounted_force, perpendicular_directions
from physics_scenes.rotations import FloatArray, specific_force
from physics_scenes.scene import Scene
from physics_scenes.world import World

MICRO = 1e-6
REMEMBERED = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)
SMALL = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


def soft_mount(world: World, size: float, chance: np.random.Generator) -> World:
    """The sensor yields inside the package: f·Q·f with tr Q = 0, Frobenius norm of the size, in a random direction.

    A compliance C turns the sensor's axis by C applied to the force on it, so its output takes products of two
    components: two periods in pitch and one in roll, as in TP's figures 37 to 41.
    """
    components = chance.standard_normal((*_shape(world), 5))
    components = components / np.linalg.norm(components, axis=-1, keepdims=True)
    return _with_q(world, size * MICRO * np.einsum("nsab,bij->nsaij", components, traceless_basis()))


def soft_mount_worst(world: World, size: float, chance: np.random.Generator) -> World:
    """The soft mount that moves a linear fit's offset most for the residuals that it leaves, either sign.

    With residuals M q and offset cᵀq of the linear fit over the design, the worst direction is (MᵀM)⁻¹c.
    """
    force = specific_force(*np.deg2rad(world.setup.points_deg()).T)
    linear = np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)
    columns = np.einsum("ki,bij,kj->kb", force, traceless_basis(), force)
    fitted = np.linalg.pinv(linear) @ columns
    left = columns - linear @ fitted
    worst = np.linalg.pinv(left.T @ left, rcond=1e-9) @ fitted[0]
    worst = worst / np.linalg.norm(worst)
    direction = np.einsum("b,bij->ij", worst, traceless_basis())
    return _with_q(world, size * MICRO * _signs(world, chance)[..., None, None] * direction)


def second_order(world: World, size: float, chance: np.random.Generator) -> World:
    """K₂: the output takes K₂a_i², a servo loop's or a beam's asymmetry of stiffness; either sign."""
    along = world.package.axis_direction
    square = along[..., :, None] * along[..., None, :]
    return _with_q(world, size * MICRO * _signs(world, chance)[..., None, None] * square)


def cross_coupling(world: World, size: float, chance: np.random.Generator) -> World:
    """K_ip: the output takes K_ip·a_i·a_p with a_p at right angles to the sensitive axis: a pendulum deflects."""
    along = world.package.axis_direction
    return _with_q(world, size * MICRO * _product(along, perpendicular_directions(along, chance)))


def cross_product(world: World, size: float, chance: np.random.Generator) -> World:
    """K_po: the output takes K_po·a_p·a_o, both at right angles to the sensitive axis and to each other."""
    along = world.package.axis_direction
    pendulous = perpendicular_directions(along, chance)
    return _with_q(world, size * MICRO * _product(pendulous, np.cross(along, pendulous)))


def cubic(world: World, size: float, chance: np.random.Generator) -> World:
    """K₃: the output takes K₃a_i³: a magnet or an amplifier that begins to saturate; either sign."""
    package = replace(world.package, cubic_per_g2=size * MICRO * _signs(world, chance))
    return replace(world, package=package)


def offset_asymmetry(world: World, size: float, chance: np.random.Generator) -> World:
    """K₀′: the offset differs by K₀′ between positive and negative input: ½K₀′sgn(a_i); a dead band, a hard stop."""
    package = replace(world.package, offset_asymmetry_g=size * MICRO * _signs(world, chance))
    return replace(world, package=package)


def gain_asymmetry(world: World, size: float, chance: np.random.Generator) -> World:
    """K₁′: the sensitivity differs by K₁′ between positive and negative input: ½K₁′|a_i|; two halves of a bridge."""
    package = replace(world.package, gain_asymmetry=size * MICRO * _signs(world, chance))
    return replace(world, package=package)


def hysteresis(world: World, size: float, chance: np.random.Generator) -> World:
    """What the sensor was turned from stays in it: size·√(|Δa|/2)·sgn(Δa), Δa = a_i before less a_i now, in µg.

    Whole for a reversal from +1 g to −1 g, less for a small turn, as an elastic after-effect or a remanence is. A
    random order makes noise of it, a fixed order makes the same error in every replication.
    """
    schedule, along = world.schedule, world.package.axis_direction
    now = mounted_force(world.setup, schedule.pitch_deg, schedule.roll_deg)
    before = mounted_force(world.setup, schedule.previous_pitch_deg, schedule.previous_roll_deg)
    change = np.einsum("dsc,nsac->ndsa", before - now, along)
    kept = np.sqrt(np.abs(change) / 2.0) * np.sign(change)
    return replace(world, added_g=world.added_g + size * MICRO * kept)


def after_effect(world: World, size: float, chance: np.random.Generator) -> World:
    """The element creeps: the output takes size·(a_i − m), m what of a_i it has followed, ṁ = (a_i − m)/τ, in µg a g.

    τ is three of the run's dwells, that of a flexure or a cement that gives way slowly (Boltzmann's after-effect, one
    time constant). The truth is what a sensor that stands still for long shows. At its first dwell it has.
    """
    schedule, along = world.schedule, world.package.axis_direction
    force = np.einsum("dsc,nsac->ndsa", mounted_force(world.setup, schedule.pitch_deg, schedule.roll_deg), along)
    time_constant_s = 3.0 * float(np.median(np.diff(schedule.time_s)))
    left = np.zeros(force.shape)
    for dwell in range(1, force.shape[1]):
        kept = np.exp(-(schedule.time_s[dwell] - schedule.time_s[dwell - 1]) / time_constant_s)
        left[:, dwell] = kept * (left[:, dwell - 1] + force[:, dwell] - force[:, dwell - 1])
    return replace(world, added_g=world.added_g + size * MICRO * left)


def carry_over(world: World, size: float, chance: np.random.Generator) -> World:
    """The scanner keeps a part of what it read last: z of the dwell before adds the size, in parts per million, to x.

    Dielectric absorption, a relay's charge, a multiplexer that is read too soon. The truth is a sensor read by itself.
    """
    leaving, entering = world.setup.axes.index("z"), world.setup.axes.index("x")

    def kept(output_v: FloatArray) -> FloatArray:
        found = output_v.copy()
        found[:, 1:, :, entering] += size * MICRO * output_v[:, :-1, :, leaving]
        return found

    return world if size == 0.0 else replace(world, faults_before_noise=(*world.faults_before_noise, kept))


def after_pitch_moves(world: World, size: float, chance: np.random.Generator) -> World:
    """After every move of the pitch axis the sensor is off by the size in µg, and comes back within a few dwells.

    Heat of the pitch motor or a cable that twists: exp(−j/2) at the j-th dwell after it, of a sign and size up to that
    for each axis.
    """
    moved = np.append(True, np.diff(world.schedule.pitch_deg) != 0.0)
    dwells = np.arange(moved.size)
    since = dwells - np.maximum.accumulate(np.where(moved, dwells, 0))
    each = chance.choice([-1.0, 1.0], _shape(world)) * chance.uniform(0.5, 1.0, _shape(world))
    course = np.exp(-since / 2.0)[None, :, None, None]
    return replace(world, added_g=world.added_g + size * MICRO * course * each[:, None])


def coning(world: World, size: float, chance: np.random.Generator) -> World:
    """Every axis lies off its nominal direction by the size in degrees, to any side: from 0.05° to 80°.

    Nothing is wrong: near 0° the azimuth is unobservable, at 80° the nominal axis hardly shows (MATH 1).
    """
    azimuth = chance.uniform(-np.pi, np.pi, _shape(world))
    angle = np.full(_shape(world), np.deg2rad(size))
    package = world.package
    vectors = coned_vectors(package.axes, package.sensitivity_v_per_g, angle, azimuth)
    return replace(world, package=replace(package, vector_v_per_g=vectors))


def saturation(world: World, size: float, chance: np.random.Generator) -> World:
    """The amplifier's rails lie inside of ±1 g by the size in percent: what would be beyond reads the rail."""
    package = world.package
    span = (1.0 - size / 100.0) * package.sensitivity_v_per_g[:, None]
    if size == 0.0:
        return world
    offset = package.offset_v[:, None]

    def clipped(output_v: FloatArray) -> FloatArray:
        return np.clip(output_v, offset - span, offset + span)

    return replace(world, faults_before_noise=(*world.faults_before_noise, clipped))


def quantisation(world: World, size: float, chance: np.random.Generator) -> World:
    """The meter resolves steps of the size in µV; a dwell's noise is 20 µV. Far above the noise it is a staircase."""
    step = size * 1e-6
    if size == 0.0:
        return world

    def rounded(output_v: FloatArray) -> FloatArray:
        return step * np.round(output_v / step)

    return replace(world, faults_after_noise=(*world.faults_after_noise, rounded))


def traceless_basis() -> FloatArray:
    """Return five symmetric matrices (5, 3, 3) with trace zero, of Frobenius norm one and at right angles."""
    basis = np.zeros((5, 3, 3))
    basis[0] = np.diag([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    basis[1] = np.diag([1.0, 1.0, -2.0]) / np.sqrt(6.0)
    for index, (i, j) in enumerate([(0, 1), (0, 2), (1, 2)], start=2):
        basis[index, i, j] = basis[index, j, i] = np.sqrt(0.5)
    return basis


def _with_q(world: World, q_per_g: FloatArray) -> World:
    before = world.package.q_per_g
    return replace(world, package=replace(world.package, q_per_g=q_per_g if before is None else before + q_per_g))


def _product(first: FloatArray, second: FloatArray) -> FloatArray:
    outer = first[..., :, None] * second[..., None, :]
    return 0.5 * (outer + np.swapaxes(outer, -1, -2))


def _shape(world: World) -> tuple[int, int, int]:
    campaigns, _, sensors, axes = world.shape
    return campaigns, sensors, axes


def _signs(world: World, chance: np.random.Generator) -> FloatArray:
    return chance.choice([-1.0, 1.0], _shape(world))


WORST_30 = {"pitch_limit_deg": 30.0}
SENSOR_SCENES = (
    Scene("soft-mount", soft_mount, "µg/g²", SMALL, "quadratic", also=("cross-coupling", "lack-of-fit")),
    Scene("soft-mount-worst", soft_mount_worst, "µg/g²", SMALL, "quadratic", also=("cross-coupling", "lack-of-fit")),
    Scene(
        "soft-mount-worst-30",
        soft_mount_worst,
        "µg/g²",
        (*SMALL, 50.0, 100.0),
        "quadratic",
        also=("cross-coupling", "lack-of-fit"),
        design=WORST_30,
    ),
    Scene("k2", second_order, "µg/g²", SMALL, "quadratic", also=("lack-of-fit", "asymmetry")),
    Scene("k3", cubic, "µg/g³", (*SMALL, 50.0), "cubic", also=("lack-of-fit", "asymmetry")),
    Scene("k0-asymmetry", offset_asymmetry, "µg", (*SMALL, 50.0), "asymmetry", also=("lack-of-fit", "cubic")),
    Scene("k1-asymmetry", gain_asymmetry, "µg/g", (*SMALL, 50.0), "asymmetry", also=("lack-of-fit", "quadratic")),
    Scene("cross-coupling", cross_coupling, "µg/g²", SMALL, "cross-coupling", also=("quadratic", "lack-of-fit")),
    Scene("cross-product", cross_product, "µg/g²", SMALL, "cross-coupling", also=("quadratic", "lack-of-fit")),
    Scene("hysteresis", hysteresis, "µg", (*SMALL, 50.0), "lack-of-fit", also=("autocorrelation",)),
    Scene(
        "hysteresis-random-order",
        hysteresis,
        "µg",
        (*SMALL, 50.0),
        design={"order": "random"},
    ),
    Scene("carry-over", carry_over, "ppm", (0.0, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0), "autocorrelation"),
    Scene("after-pitch-moves", after_pitch_moves, "µg", (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 100.0), "drift"),
    Scene("after-effect", after_effect, "µg", REMEMBERED, "autocorrelation"),
    Scene("after-effect-random-order", after_effect, "µg", REMEMBERED, "autocorrelation", design={"order": "random"}),
    Scene(
        "after-effect-raster", after_effect, "µg", REMEMBERED, "autocorrelation", design={"order": "raster-and-back"}
    ),
    Scene("coning", coning, "deg", (0.05, 0.1, 0.5, 2.0, 10.0, 45.0, 80.0), declared_up_to=80.0, zero_is_clean=False),
    Scene(
        "saturation",
        saturation,
        "%",
        (0.0, 0.0007, 0.001, 0.0015, 0.002, 0.003, 0.01, 0.1, 1.5, 5.0),
        "lack-of-fit",
        also=("cubic",),
    ),
    Scene("quantisation", quantisation, "µV", (0.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 500.0), also=("lack-of-fit",)),
)
