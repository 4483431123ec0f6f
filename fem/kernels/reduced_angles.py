"""What contacts of the reduced model give way by the forces on their neighbours, at the angles where these are.

Compliances along a ring go with the angle between two rollers. Within AGAIN steps they change by far less than what
forces are solved to. Their slopes times neighbours' forces tilt a raceway, and with it a contact's force: rollers that
neither friction nor a cage holds apart are spread by that.
"""

from fem.kernels.jit import part
from fem.kernels.lane_functions import arc_tangent, larger, smaller
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, select
from fem.kernels.reduced_housing import ring_place

AGAIN = 16  # steps, and at samples; a checkpoint needs none of it


@part(inlined=False)
def follow_angles(bodies, compliance, forces):
    """Compliances along both rings, and their slopes, where rollers are now."""
    columns, most, strayed = bodies.columns, compliance.strays, forces.strayed
    neighbours, bent = compliance.distance.size, compliance.bent
    _stray(bodies, compliance, forces)
    for row in range(2):
        for k in range(compliance.felt[row, 0]):
            along, steep, distance = compliance.along[row, k], compliance.steep[row, k], compliance.distance[k]
            a, b, c, d = bent[row, 0, k], bent[row, 1, k], bent[row, 2, k], bent[row, 3, k]
            for group in range(0, bodies.n, WIDTH):
                at, to = forces.halo + group, (row * neighbours + k) * columns + group
                off = load(strayed, at + distance) - load(strayed, at)
                x = larger(smaller(off, most), -most)
                store(forces.along, to, along + x * (steep + x * (a + x * (b + x * (c + x * d)))))
                slope = steep + x * (2.0 * a + x * (3.0 * b + x * (4.0 * c + x * (5.0 * d))))
                store(forces.steep, to, select(x == off, slope, 0.0))


@part
def _stray(bodies, compliance, forces):
    """Tell by how much rollers are ahead of equal angles from the first one's, about the outer ring.

    About the hub they are ahead by as much but for a thousandth of a roller's distance.
    """
    columns, n, halo, strayed = bodies.columns, bodies.n, forces.halo, forces.strayed
    ring_x, ring_y = ring_place(bodies.housing)
    x, y = bodies.centre[0, 0] - ring_x, bodies.centre[1, 0] - ring_y
    for group in range(0, n, WIDTH):
        c, s = load(compliance.apart, group), load(compliance.apart, columns + group)
        to_x, to_y = c * x - s * y, s * x + c * y
        here_x, here_y = load(bodies.centre, group) - ring_x, load(bodies.centre, columns + group) - ring_y
        store(strayed, halo + group, arc_tangent(to_x * here_y - to_y * here_x, to_x * here_x + to_y * here_y))
    for k in range(halo):
        strayed[halo - 1 - k] = strayed[halo + n - 1 - k]
        strayed[halo + n + k] = strayed[halo + k]
