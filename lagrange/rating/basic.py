"""Basic ratings of a bearing, of rollers or balls. mm and N."""

from dataclasses import dataclass

from lagrange.bearing import BallBearing, Bearing
from lagrange.rating.capacity import (
    MEDIUM,
    Dimensions,
    ball_dynamic_capacity,
    ball_static_capacity,
    complete_and_of_steel,
    dynamic_capacity,
    fatigue_load_limit,
    static_capacity,
)
from lagrange.rating.sources import Unavailable

OPEN_GROOVES = 0.52, 0.53  # of a ball's diameter, inner and outer: ISO 281 rates to grooves of at most these radii
ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True)
class Basic:
    """Of all rows together."""

    dynamic: float  # C
    static: float  # C0
    fatigue: float  # C_u
    pitch: float  # D_pw

    @classmethod
    def of(cls, bearing: Bearing) -> "Basic":
        """Unavailable: not complete or not of steel; of balls, grooves wider than the standard rates."""
        if isinstance(bearing, BallBearing):
            return cls._of_balls(bearing)
        row = Dimensions.of(bearing)
        return cls(
            dynamic=dynamic_capacity(row),
            static=static_capacity(row),
            fatigue=fatigue_load_limit(row),
            pitch=row.pitch,
        )

    @classmethod
    def _of_balls(cls, bearing: BallBearing) -> "Basic":
        complete_and_of_steel(bearing)
        diameter, pitch = 2e3 * bearing.element_radius, 2e3 * bearing.pitch_radius
        grooves = bearing.inner_groove_radius, bearing.outer_groove_radius
        for side, groove, most in zip(("inner", "outer"), grooves, OPEN_GROOVES, strict=True):
            if 1e3 * groove > (most + ROUNDING) * diameter:
                raise Unavailable(
                    f"ratings are those of an {side} groove radius up to {most:g} of the ball's diameter; "
                    f"this one has {1e3 * groove / diameter:.4g}"
                )
        sizes = bearing.n_rollers, diameter, pitch, bearing.cosine, bearing.rows
        static = ball_static_capacity(*sizes)
        return cls(
            dynamic=ball_dynamic_capacity(*sizes),
            static=static,
            fatigue=static / 22.0 * min(1.0, (MEDIUM / pitch) ** 0.5),
            pitch=pitch,
        )
