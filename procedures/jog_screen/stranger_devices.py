"""Whether the devices behind lines that are open again are those of the start."""


def difference(before: dict[str, str], now: dict[str, str]) -> str:
    """Return which other devices answer than at the start; empty where none does."""
    other = [
        f"{key} was {identity!r} and is {now.get(key)!r}"
        for key, identity in before.items()
        if now.get(key) != identity
    ]
    return f"other devices answer than before: {'; '.join(other)}; put the cables right and start anew" if other else ""
