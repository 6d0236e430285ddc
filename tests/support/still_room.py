"""A room that stays as warm as it is, whatever the chamber in it was told."""


class StillRoom:
    """At 25 °C, wherever it is sent."""

    def __init__(self) -> None:
        self.held_degc = 25.0

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 25.0

    def setpoint_degc(self, environment: str) -> float:
        return self.held_degc

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.held_degc = setpoint_degc
