"""Lagrange's equations derived from T and V by computer algebra, evaluated with 40 digits.

T and V are typed in from the paper's (2), (3), (14)-(19), (26), (27); nothing of `lagrange` is used.
"""

import mpmath as mp
import sympy as sp

DIGITS = 40


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
