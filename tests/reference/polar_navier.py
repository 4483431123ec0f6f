"""Navier's equations of one angular harmonic in plane strain, collocated: independent of any series of potentials."""

import numpy as np
from numpy.polynomial import chebyshev, legendre


class PolarNavier:
    """U, V of u_r = U cos nθ, u_θ = V sin nθ as Chebyshev series in r; Navier by divergence and curl."""

    def __init__(self, n, inner, outer, degree, material):
        self.n, self.outer, self.inner, self.degree = n, outer, inner, degree
        self.lam, self.mu = material.lame_lambda / material.lame_mu, 1.0

    def series(self, r, derivative):
        x = (2.0 * r - self.inner - self.outer) / (self.outer - self.inner)
        basis = (
            chebyshev.chebder(np.eye(self.degree + 1), derivative, axis=0) if derivative else np.eye(self.degree + 1)
        )
        return chebyshev.chebval(x, basis).T * (2.0 / (self.outer - self.inner)) ** derivative

    def blocks(self, r):
        """Rows (..., 2 (degree+1)) of U, V, σ_rr, σ_rθ and of Navier's equations times r², at radii r."""
        n, lam, mu = self.n, self.lam, self.mu
        r = np.atleast_1d(np.asarray(r, dtype=float))
        f, df, ddf = (self.series(r, k) for k in range(3))
        c = r[:, None]
        zero = np.zeros_like(f)
        U, V = np.hstack((f, zero)), np.hstack((zero, f))
        dU, dV = np.hstack((df, zero)), np.hstack((zero, df))
        ddU, ddV = np.hstack((ddf, zero)), np.hstack((zero, ddf))
        div = dU + (U + n * V) / c
        ddiv = ddU + (dU + n * dV) / c - (U + n * V) / c**2
        curl = dV + (V + n * U) / c
        dcurl = ddV + (dV + n * dU) / c - (V + n * U) / c**2
        navier_r = (lam + 2 * mu) * ddiv - mu * n / c * curl
        navier_t = -(lam + 2 * mu) * n / c * div + mu * dcurl
        s_rr, s_rt = lam * div + 2 * mu * dU, mu * (dV - (V + n * U) / c)
        return U, V, s_rr, s_rt, c**2 * navier_r, c**2 * navier_t

    def solve(self, conditions, force=(0.0, 0.0)):
        """Coefficients of div σ + force = 0, collocated, with row @ coefficients = value per condition."""
        points = (
            0.5 * (self.inner + self.outer) + 0.5 * (self.outer - self.inner) * legendre.leggauss(self.degree + 1)[0]
        )
        *_, navier_r, navier_t = self.blocks(points)
        rows = np.vstack((navier_r, navier_t, *(row.reshape(1, -1) for row, _ in conditions)))
        values = np.concatenate((-force[0] * points**2, -force[1] * points**2, [value for _, value in conditions]))
        scale = np.linalg.norm(rows, axis=1)
        scale[scale == 0.0] = 1.0
        coefficients = np.linalg.lstsq(rows / scale[:, None], values / scale, rcond=1e-14)[0]
        assert np.max(np.abs((rows @ coefficients - values) / scale)) < 1e-9  # converged
        return coefficients
