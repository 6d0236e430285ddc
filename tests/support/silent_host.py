"""A host that drives one axis at a port until it is killed: homes it, arms its watchdog, lets it go, keeps talking.

Called as ``python silent_host.py DRIVER ADDRESS WATCHDOG_S FACTOR`` (rig seconds in a second); says ``moving`` once
the axis moves.
"""

import sys

from motion_bench import DRIVERS, settings_of

from rig.clock import ScaledClock, SystemClock
from rig.link.ports import open_stream
from rig.motion.move import home_and_arrive

FEED_S = 1.0


def main(driver: str, address: str, watchdog_s: str, factor: str) -> None:
    clock = ScaledClock(float(factor))
    axes = settings_of(driver, watchdog_s=float(watchdog_s))
    axis = DRIVERS[driver].connect(axes, open_stream(address, clock=SystemClock()))["pitch"]
    if driver == "oriental-az":  # a Maestro has its time-out from its own settings
        axis.arm_watchdog(clock.sleep)  # type: ignore[attr-defined]
    home_and_arrive(axis, clock, clock.sleep)
    if hasattr(axis, "start_rate"):
        axis.start_rate(2.0)
    else:
        axis.start_move(170.0)
    sys.stdout.write("moving\n")
    sys.stdout.flush()
    while True:
        axis.feed_watchdog()  # type: ignore[attr-defined]
        clock.sleep(FEED_S)


if __name__ == "__main__":
    main(*sys.argv[1:])
