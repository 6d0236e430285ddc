"""Watlow F4 chamber controller, Modbus RTU."""

from typing import Annotated, Literal

from pydantic import Field

from rig.settings import EnvironmentSettings


class WatlowF4Settings(EnvironmentSettings):
    """``driver = "watlow-f4"``."""

    driver: Literal["watlow-f4"]
    unit: Annotated[int, Field(ge=1, le=247)] = 1
    baud_rate: Literal[9600, 19200] = 9600
