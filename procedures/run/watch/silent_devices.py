"""Whether one line is silent or many: who is woken by the first should not look at one cable where a hub is dark."""

from procedures.run.dwell.measure import OpenRig
from rig.abilities.abilities import Wait
from rig.errors import RigError

LIMIT_S = 15.0
"""Rig seconds: people are told after it, whoever was not asked until then."""


def silence_words(rig: OpenRig, look: Wait) -> str:
    """Ask every device who it is; return which are silent where it is not one alone, to follow a sentence.

    ``look`` hears of requests between two questions. Raises: WaitEnded.
    """
    devices = rig.by_table()
    silent: list[str] = []
    ends_s = rig.clock.monotonic_s() + LIMIT_S
    for name, device in devices.items():
        if rig.clock.monotonic_s() > ends_s:
            break
        look(0.0)
        try:
            device.identify()
        except RigError:
            silent.append(name)
    if len(silent) < 2:
        return ""
    names = ", ".join(silent)
    if len(silent) == len(devices):
        return f"; no device of the rig answers ({names}): look at what they share, such as power, a hub or the network"
    return f"; no answer now from {names}"
