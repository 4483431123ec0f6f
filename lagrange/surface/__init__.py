"""Surfaces that are not perfect circles: spalls, waviness, unequal rollers, measured heights, a film."""
