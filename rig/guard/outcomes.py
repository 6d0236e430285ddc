"""What a stop guard says of what it sent to an axis: in its record, to who asked, and to the engine."""

STOP_SENT = "told to stop"
STOOD = "stood; nothing was sent"
SLOWED = "told to go at its lowest speed; the program that moves it, which has its line, stops it"
WAY_UNKNOWN = "where it came from is not known"
UNASKED = "it did not answer in time"
ENGINE_LIVES = "the program that has its line cannot be ended"


def goes_on(why: str) -> str:
    """Return that a servo was slowed and not stopped: what is trusted of it is the order that it follows."""
    return f"NOT told to stop: it goes on at its lowest speed to where it was sent: {why}"
