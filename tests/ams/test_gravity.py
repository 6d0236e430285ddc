"""Normal gravity against what is published of WGS 84, and the sentences about a gravity of another place."""

import numpy as np
import pytest

from ams.gravity import disagreement, normal_gravity_mps2

PUBLISHED = [(0.0, 9.7803253359), (90.0, 9.8321849378), (-90.0, 9.8321849378)]
"""NIMA TR8350.2, table 3.4: at the equator and at the poles."""
MEAN_MPS2 = 9.7976432222
"""The same: mean over the ellipsoid."""
GRS80_45_MPS2 = 9.806199203
"""Moritz, Geodetic Reference System 1980: at 45°; WGS 84 differs by 1.4e-6 m/s²."""


@pytest.mark.parametrize(("latitude_deg", "published_mps2"), PUBLISHED)
def test_normal_gravity_is_the_published_one(latitude_deg: float, published_mps2: float) -> None:
    assert normal_gravity_mps2(latitude_deg) == pytest.approx(published_mps2, abs=1e-9)


def test_at_45_degrees_it_is_that_of_the_reference_system_within_two_parts_in_ten_million() -> None:
    assert normal_gravity_mps2(45.0) == pytest.approx(GRS80_45_MPS2, abs=2e-6)


def test_its_mean_over_the_ellipsoid_is_the_published_one() -> None:
    """Weighted by the area of a zone, (1 − e²) cos φ / (1 − e² sin² φ)²."""
    squared, latitude = 0.00669437999014, np.deg2rad(np.linspace(-90.0, 90.0, 20_001))
    area = np.cos(latitude) / (1.0 - squared * np.sin(latitude) ** 2) ** 2
    gravity = np.array([normal_gravity_mps2(entry) for entry in np.rad2deg(latitude)])
    assert np.sum(gravity * area) / np.sum(area) == pytest.approx(MEAN_MPS2, abs=1e-8)


def test_free_air_is_three_tenths_of_a_milligal_a_metre() -> None:
    """0.3086 mGal/m at 45°, the figure of every handbook; 100 m are 0.00031 m/s², a degree at 45° is 0.0009."""
    at_45 = normal_gravity_mps2(45.0)
    assert (at_45 - normal_gravity_mps2(45.0, 1.0)) * 1e5 == pytest.approx(0.3086, abs=2e-4)
    assert at_45 - normal_gravity_mps2(45.0, 100.0) == pytest.approx(0.00031, abs=5e-6)
    assert normal_gravity_mps2(46.0) - at_45 == pytest.approx(0.0009, abs=2e-5)


@pytest.mark.parametrize(
    ("gravity_mps2", "latitude_deg", "height_m", "kind"),
    [
        (9.79826, 37.09, 10.0, None),  # Hampton, Virginia, as surveyed: 0.0009 below normal
        (9.8126, 52.4, 80.0, None),  # Potsdam, whose pendulums gave 9.81274 and whose gravity is 9.81260
        (9.78, 19.43, 2240.0, None),  # Mexico City: 9.7793 and some
        (9.80665, 37.09, 10.0, "refused"),
        (9.8015, 37.09, 0.0, "told"),
        (9.80665, 0.0, None, "refused"),
        (9.79, 37.09, None, None),  # what 2.9 km up would have
    ],
)
def test_a_gravity_is_held_against_its_place(
    gravity_mps2: float, latitude_deg: float, height_m: float | None, kind: str | None
) -> None:
    found = disagreement(gravity_mps2, latitude_deg, height_m)
    assert (None if found is None else found.kind) == kind
    if found is not None:
        assert f"{gravity_mps2:.5f} m/s²" in found.text
        assert "WGS 84" in found.text
