"""Indexing tables with a curvic coupling: they stop only at multiples of their increment, and are exact there."""

from typing import Literal

from pydantic import Field

from rig.settings import AxisSettings


class IndexingTableSettings(AxisSettings):
    """``driver = "indexing-table"``."""

    driver: Literal["indexing-table"]
    increment_deg: float = Field(gt=0.0)
    dialect: str | None = None
    """Name of a shipped dialect or path of a dialect file; by default it follows from the increment."""
