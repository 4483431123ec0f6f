"""What a scene says of the Lagrangian model and of ball bearings."""

import pytest

from lagrange import BallBearing
from lagrange.scene.scene import Scene, parse_scene, parse_scene_text

BALLS = {
    "type": "ball", "rollers": 9, "roller_diameter_mm": 12.7, "roller_length_mm": 19.0,
    "inner_raceway_diameter_mm": 52.291, "outer_raceway_diameter_mm": 77.706,
    "bore_diameter_mm": 45.0, "outside_diameter_mm": 85.0,
}  # fmt: skip


def balls(**changes):
    return parse_scene({"bearing": BALLS | changes, "operation": {"inner_ring_and_shaft_kg": 0.5}}, "s.toml")


def test_balls_in_si_with_the_grooves_of_the_standard():
    """ISO 281 rates grooves of 0.52 and 0.53 of the ball's diameter."""
    bearing = balls().ideal_bearing()
    assert isinstance(bearing, BallBearing) and bearing.n_rollers == 9
    assert bearing.roller_radius == pytest.approx(6.35e-3)
    assert (bearing.inner_groove_radius, bearing.outer_groove_radius) == pytest.approx((6.604e-3, 6.731e-3))
    assert balls(inner_conformity=0.515).ideal_bearing().inner_groove_radius == pytest.approx(0.515 * 12.7e-3)
    assert not isinstance(Scene().ideal_bearing(), BallBearing)


def test_a_ball_bearing_has_its_own_law_and_survives_the_round_trip():
    scene = balls()
    assert scene.lagrange.law == "hertz" and Scene().lagrange.law == "harris"
    assert parse_scene_text(scene.to_toml(), "again") == scene
    assert "inner_conformity = 0.52" in scene.to_toml() and "conformity" not in Scene().to_toml()


def test_balls_need_no_mesh_size():
    balls(roller_diameter_mm=6.0, inner_raceway_diameter_mm=65.6)
    small = {"roller_diameter_mm": 1.0, "inner_raceway_diameter_mm": 75.7}
    assert balls(**small).numerics.mesh_size_mm == 1.0
    assert balls(type="roller", **small).numerics.mesh_size_mm == 0.1  # a tenth of a roller
