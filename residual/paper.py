"""What the paper's figures show, read off their axes, and which runs may be set beside them.

Source: Rubio, García Prada, Castejón, Laniado (IFToMM 2007), figures 6 to 11. Ranges, not data.
"""

from lagrange.scene import Scene

INNER_X = -80e-6, 60e-6  # m, figure 6
INNER_Y = -220e-6, -80e-6  # m
ROLLER_RHO = 22.98e-3, 23.08e-3  # m, figure 7
ROLLER_VELOCITY = -0.4, 0.4  # m/s
ROLLER_ACCELERATION = -5e3, 5e3  # m/s²
ERROR_FORCE = -3000.0, 3000.0  # N, figures 8 and 9, around 0 and around the load
PEAK = 22.0  # Hz, figures 10 and 11


def is_paper(scene: Scene) -> bool:
    """Whether the scene's bearing and operating point are the paper's."""
    paper = Scene()
    return scene.bearing == paper.bearing and (
        scene.operation.speed_rpm == paper.operation.speed_rpm
        and scene.operation.radial_load_N == paper.operation.radial_load_N
    )
