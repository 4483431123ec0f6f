"""Static equilibrium of the paper's bearing, resolved, computed independently of this project.

Every body on its own locally refined mesh of quadratic elements (six of them across the contact half-width),
self-consistent Hertz pressures; frictionless, weightless, standing; rigid bore (25 mm) and rigid outside diameter
(65 mm); 2000 N. Converged to 0.02 %.
"""

from math import pi

# angle of the first roller, rad; hub displacement along the load, µm; loads of the seven most loaded rollers, N
RESOLVED = {
    "on a roller": (-0.5 * pi, 3.6140, (628.5, 549.5, 549.5, 337.2, 337.2, 62.9, 62.9)),
    "between rollers": (-0.5 * pi + pi / 13.0, 3.6012, (606.0, 606.0, 454.8, 454.8, 200.8, 200.8, 0.0)),
}
