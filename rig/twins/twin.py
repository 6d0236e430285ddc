"""What a twin is: a device seen from its other side, with the physical world behind it."""

from typing import Protocol

from rig.link.memory import Peer


class Twin(Peer, Protocol):
    """A device as bytes in, bytes out: no port, no thread; time is an argument (rig seconds).

    The same twin serves a memory line, a pseudo-terminal and a TCP port.
    """
