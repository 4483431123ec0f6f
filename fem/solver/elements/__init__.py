"""Finite elements: `plan` (all decided before the first step), `start`, `arrays` and the fields read off them."""
