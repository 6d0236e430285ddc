"""Several packages on a table that slips, unseen, while they are calibrated; visits at two attitudes."""

from collections.abc import Callable
from pathlib import Path

from small_run import RIG, Bench, bench
from unattended_run import UnattendedRun, events

from rig.twins.physics.world import World

TWO = (
    ("reference_every = 7", "reference_every = 3\npitch_deg = [0.0, 30.0]\nroll_deg = [0.0, 60.0]"),
    ("replications = 2", "replications = 1"),
)


def several_sensors(
    folder: Path, count: int, procedure: tuple[tuple[str, str], ...] = TWO, rig: tuple[tuple[str, str], ...] = ()
) -> Bench:
    """Packages on one meter, each a little different; ``procedure``: what is changed in that of the small run.

    ``rig``: what else is changed in its rig.
    """
    names = tuple(f"SN{index}" for index in range(1, count + 1))
    channels = ", ".join(
        f"{name}{axis} = {{ scanner = {100 * (1 + index // 3) + 3 * (index % 3) + number}, range_v = 10.0 }}"
        for index, name in enumerate(names)
        for number, axis in enumerate("xyz")
    )
    meter = next(line for line in RIG.splitlines() if line.startswith("channels = { x = { scanner"))
    sensors = "".join(
        f'[sensors.{name}]\nmodel = "three-axis package"\nnominal_sensitivity_v_per_g = 2.5\n'
        f'channels = {{ x = "dmm.{name}x", y = "dmm.{name}y", z = "dmm.{name}z" }}\n'
        for name in names
    )
    truths = "".join(
        f"[twin.truth.{name}]\n"
        + "".join(
            f"{axis} = {{ offset_v = {0.002 * index - 0.005}, sensitivity_v_per_g = {2.5 + 0.004 * index}, "
            f"coning_deg = 0.4, azimuth_deg = {40.0 * index - 150.0}, noise_v = 2e-5 }}\n"
            for axis in "xyz"
        )
        for index, name in enumerate(names)
    )
    old_sensor = RIG[RIG.index("[sensors.SN1]") : RIG.index("[twin]")]
    old_truth = RIG[RIG.index("[twin.truth.SN1]") :]
    packages = ((meter, f"channels = {{ {channels} }}"), (old_sensor, sensors), (old_truth, truths))
    return bench(folder, rig=(*packages, *rig), procedure=procedure)


def slips(axis: str, by_deg: float) -> Callable[[UnattendedRun], None]:
    def slip(unattended: UnattendedRun) -> None:
        world = unattended.rig.chance
        assert isinstance(world, World)
        world.slip(axis, by_deg, unattended.rig.clock.monotonic_s(), seen=False)

    return slip


def common_mode_events(run_dir: Path) -> list[tuple[list[str], bool, str]]:
    return [
        (list(event.detail["kinds"]), bool(event.detail["held"]), str(event.detail["text"]))  # type: ignore[call-overload]
        for event in events(run_dir, "common_mode")
    ]
