"""Functions of eight lanes, or of scalars, to round-off; loads and stores of two registers.

Arguments reduced as in Sun's fdlibm (s_atan.c, e_log.c, e_exp.c, k_sin.c, k_cos.c, 1993), with its minimax
coefficients.
"""

from math import log, pi

from fem.kernels import lanes
from fem.kernels.jit import part
from fem.kernels.lanes import absolute, load, select, store, to_float, to_int

TAN_EIGHTH = 0.41421356237309503  # tan(π/8)
LN_2 = log(2.0)
LN_2_HIGH, LN_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # the first has 32 bits
ROOT_2 = 1.4142135623730951
# π/2 in three parts; the first two have 33 bits, so that their multiples are exact
HALF_PI_1, HALF_PI_2, HALF_PI_3 = 1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21


@part
def _polynomial(x, a, b, c, d, e):
    """a + b x + c x² + d x³ + e x⁴ by Horner's rule."""
    return a + x * (b + x * (c + x * (d + x * e)))


@part
def arc_tangent(y, x):
    """Angle of (x, y) in (−π, π], rad."""
    wide, high = absolute(x), absolute(y)
    steep = high > wide
    small, large = select(steep, wide, high), select(steep, high, wide)
    upper = small > TAN_EIGHTH * large
    t = select(upper, small - large, small) / select(upper, small + large, large)
    z = t * t
    w = z * z
    e = 4.97687799461593236017e-02 + w * 1.62858201153657823623e-02
    even = z * _polynomial(
        w, 3.33333333333329318027e-01, 1.42857142725034663711e-01,
        9.09088713343650656196e-02, 6.66107313738753120669e-02, e,
    )  # fmt: skip
    odd = w * _polynomial(
        w, 1.99999999998764832476e-01, 1.11111104054623557880e-01,
        7.69187620504482999495e-02, 5.83357013379057348645e-02, 3.65315727442169155270e-02,
    )  # fmt: skip
    angle = t + t * (odd - even)
    angle = select(upper, angle + 0.25 * pi, angle)
    angle = select(steep, 0.5 * pi - angle, angle)
    return lanes.with_sign(select(x < 0.0, pi - angle, angle), y)


@part
def logarithm(x):
    """Natural logarithm of positive numbers."""
    power, m = lanes.exponent_and_mantissa(x)
    above = m > ROOT_2
    m, power = select(above, 0.5 * m, m), select(above, power + 1.0, power)
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    e = 1.818357216161805012e-01 + z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01)
    R = z * _polynomial(
        z, 6.666666666666735130e-01, 3.999999999940941908e-01,
        2.857142874366239149e-01, 2.222219843214978396e-01, e,
    )  # fmt: skip
    half = 0.5 * f * f
    return power * LN_2 + (f - (half - s * (half + R)))


@part
def exponential(x):
    """e to the power of numbers from −700 to 700."""
    power = to_int(x * (1.0 / LN_2) + select(x < 0.0, -0.5, 0.5))
    twos = to_float(power)
    high, low = x - twos * LN_2_HIGH, twos * LN_2_LOW
    r = high - low
    z = r * r
    c = r - z * _polynomial(
        z, 1.66666666666666019037e-01, -2.77777777770155933842e-03,
        6.61375632143793436117e-05, -1.65339022054652515390e-06, 4.13813679705723846039e-08,
    )  # fmt: skip
    return (1.0 - ((low - r * c / (2.0 - c)) - high)) * lanes.power_of_two(power)


@part
def cosine_and_sine(angle):
    """Of angles of any sign up to some 10⁶ rad."""
    size = absolute(angle)
    quarter = to_int(size * (2.0 / pi) + 0.5)
    turns = to_float(quarter)
    r = ((size - turns * HALF_PI_1) - turns * HALF_PI_2) - turns * HALF_PI_3
    z = r * r
    e = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    a, b, c = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
    s = r + r * z * (a + z * (b + z * (c + z * e)))
    e = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    a, b, c = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
    c = 1.0 - 0.5 * z + z * z * (a + z * (b + z * (c + z * e)))
    beyond = turns - 4.0 * to_float(to_int(0.25 * turns))  # quarters past a whole turn: 0, 1, 2, 3
    odd = (beyond == 1.0) | (beyond == 3.0)
    cosine, sine = select(odd, s, c), select(odd, c, s)
    cosine = select((beyond == 1.0) | (beyond == 2.0), -cosine, cosine)
    sine = select(beyond >= 2.0, -sine, sine)
    return cosine, select(angle < 0.0, -sine, sine)


@part
def minimum(a, b):
    """The smaller of two, lane by lane; the second where one is not a number."""
    return select(a < b, a, b)


@part
def maximum(a, b):
    """The larger of two, lane by lane; the second where one is not a number."""
    return select(a > b, a, b)


@part
def load_pair(array, at, apart):
    """Lanes at an index, and `apart` further: x and y, or of the inner and the outer contact."""
    return load(array, at), load(array, at + apart)


@part
def store_pair(array, at, apart, one, other):
    """Write what `load_pair` reads."""
    store(array, at, one)
    store(array, at + apart, other)


@part
def next_rollers(group, n):
    """The rollers after eight from `group` on, lanes; of the last and of spare lanes the first."""
    after = lanes.count_from(group) + 1
    return select(after >= n, 0, after)
