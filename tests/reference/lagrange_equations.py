"""Lagrange's equations derived from T and V by computer algebra, evaluated with 40 digits.

T and V are typed in from the paper's (2), (3), (14)-(19), (26), (27); nothing of `lagrange` is used.
"""

from functools import cache

import mpmath as mp
import sympy as sp

DIGITS = 40


@cache
def derived_equations(n_rollers: int, exponent: sp.Rational):
    """Left sides d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q + ∂D/∂q̇, as one function of numbers.

    D = ½ d Σ δ̇² of the closed contacts is Rayleigh's dissipation function of viscous dampers beside the springs.
    The function takes (parameters, q, q̇, q̈), parameters = (m, M, g, W, r_in, r_out, r, K_in, K_out, d) and
    q = (x, y, ρ_1 … ρ_N, θ_1 … θ_N), and gives a list in the order of q. W is part of V, as W y.
    """
    t = sp.Symbol("t")
    parameters = sp.symbols("m M g W r_in r_out r K_in K_out d", positive=True)
    m, M, g, W, r_in, r_out, r, K_in, K_out, d = parameters
    x, y = sp.Function("x")(t), sp.Function("y")(t)
    rho = [sp.Function(f"rho{j}")(t) for j in range(n_rollers)]
    theta = [sp.Function(f"theta{j}")(t) for j in range(n_rollers)]
    q = [x, y, *rho, *theta]
    T = M * (x.diff(t) ** 2 + y.diff(t) ** 2) / 2
    V, D = (M * g + W) * y, 0
    for p, a in zip(rho, theta, strict=True):
        T += m * (p.diff(t) ** 2 + p**2 * a.diff(t) ** 2) / 2
        chi = sp.sqrt(x**2 + y**2 + p**2 - 2 * p * (x * sp.cos(a) + y * sp.sin(a)))
        V += m * g * p * sp.sin(a)
        V += K_in * sp.Max(r_in + r - chi, 0) ** (exponent + 1) / (exponent + 1)
        V += K_out * sp.Max(p + r - r_out, 0) ** (exponent + 1) / (exponent + 1)
        for depth in (r_in + r - chi, p + r - r_out):
            D += d * sp.Heaviside(depth) * depth.diff(t) ** 2 / 2
    rates, seconds, plain = sp.symbols(f"v:{len(q)}"), sp.symbols(f"a:{len(q)}"), sp.symbols(f"q:{len(q)}")
    swap = [(s.diff(t, 2), a) for s, a in zip(q, seconds, strict=True)]
    swap += [(s.diff(t), v) for s, v in zip(q, rates, strict=True)]
    swap += list(zip(q, plain, strict=True))
    equations = [(T.diff(s.diff(t)).diff(t) - T.diff(s) + V.diff(s) + D.diff(s.diff(t))).subs(swap) for s in q]
    step = {"Heaviside": lambda depth, at_zero=0: mp.mpf(depth > 0), "Max": max, "max": max}
    function = sp.lambdify((parameters, plain, rates, seconds), equations, modules=[step, "mpmath"], cse=True)

    def evaluate(*numbers):
        with mp.workdps(DIGITS):
            return [float(value) for value in function(*([mp.mpf(float(n)) for n in row] for row in numbers))]

    return evaluate


class Stored(sp.Function):
    """Energy of a contact by its depth, K = 1."""

    def fdiff(self, argindex=1):
        return Pushed(self.args[0])


class Pushed(sp.Function):
    """Force of a contact by its depth, K = 1; its values are numbers' alone."""


def derived_tilt_equations(n_rollers: int, exponent: float, place: list[float], drop: list[float]):
    """The same with tilt and skew of rollers and a hub that tilts; contacts by slices of a power law, no dampers.

    The function takes parameters = (m, M, g, W, r_in, r_out, r, K_in, K_out, I_t, I_a, w, I_h, J, Ω, k, b₀x, b₀y), K of
    a slice, J the hub's inertia about its axis, and q = (x, y, ρ, θ, τ, σ, b_x, b_y), which is the order of the
    equations. Slopes of the bodies' axes are typed in along x and y; spins enter as ½ I w (a_y ȧ_x − a_x ȧ_y).
    """
    parameters = sp.symbols("m M g W r_in r_out r K_in K_out I_t I_a w I_h J Omega k b0x b0y")
    m, M, g, W, r_in, r_out, r, K_in, K_out, I_t, I_a, w, I_h, J, speed, k, b0x, b0y = parameters
    q = sp.symbols(f"q:{4 * n_rollers + 4}")
    rates, seconds = sp.symbols(f"v:{len(q)}"), sp.symbols(f"a:{len(q)}")

    def rate(of):
        return sum(of.diff(s) * v for s, v in zip(q, rates, strict=True))

    (x, y), (bx, by) = q[:2], q[-2:]
    T = (M * (rate(x) ** 2 + rate(y) ** 2) + I_h * (rate(bx) ** 2 + rate(by) ** 2)) / 2
    T += J * speed * (by * rate(bx) - bx * rate(by)) / 2
    V = (M * g + W) * y + k * ((bx - b0x) ** 2 + (by - b0y) ** 2) / 2
    for p, a, tilt, skew in zip(*(q[2 + i * n_rollers : 2 + (i + 1) * n_rollers] for i in range(4)), strict=True):
        X, Y = p * sp.cos(a), p * sp.sin(a)
        ax, ay = tilt * sp.cos(a) + skew * sp.sin(a), tilt * sp.sin(a) - skew * sp.cos(a)
        T += m * (rate(X) ** 2 + rate(Y) ** 2) / 2 + I_t * (rate(ax) ** 2 + rate(ay) ** 2) / 2
        T += I_a * w * (ay * rate(ax) - ax * rate(ay)) / 2
        V += m * g * Y
        for K, reach, sign, (sx, sy), (ux, uy) in (
            (K_in, r_in + r, -1, (X - x, Y - y), (ax - bx, ay - by)), (K_out, r_out - r, 1, (X, Y), (ax, ay)),
        ):  # fmt: skip
            chi = sp.sqrt(sx**2 + sy**2)
            for z, P in zip(place, drop, strict=True):
                V += K * Stored(sign * (chi - reach + z * (ux * sx + uy * sy) / chi) - P)
    equations = [
        rate(T.diff(v)) + sum(T.diff(v, u) * a for u, a in zip(rates, seconds, strict=True)) - T.diff(s) + V.diff(s)
        for s, v in zip(q, rates, strict=True)
    ]
    power = mp.mpf(exponent)
    function = sp.lambdify(
        (parameters, q, rates, seconds), equations,
        modules=[{"Pushed": lambda depth: max(depth, mp.mpf(0)) ** power}, "mpmath"], cse=True,
    )  # fmt: skip

    def evaluate(*numbers):
        with mp.workdps(DIGITS):
            return [float(value) for value in function(*([mp.mpf(float(n)) for n in row] for row in numbers))]

    return evaluate
