"""The functions of `lanes` as plain numpy, for a time loop that runs under NUMBA_DISABLE_JIT=1: slow, but steppable.

Eight lanes are an array of eight numbers, which operators replace and never change.
"""

import numpy as np

np.seterr(all="ignore")  # division follows IEEE 754 and raises nothing, as in compiled kernels

WIDTH = 8


class Lanes(np.ndarray):
    """Eight numbers; `a += b` makes new ones, as it does in compiled kernels."""

    def __iadd__(self, other):
        return self + other

    def __isub__(self, other):
        return self - other


def _lanes(values):
    return np.asarray(values).view(Lanes) if np.ndim(values) else values


def splat(scalar):
    return _lanes(np.full(WIDTH, scalar))


def from_left(before, lanes):
    return _lanes(np.concatenate((before[-1:], lanes[:-1])))


def from_right(lanes, after):
    return _lanes(np.concatenate((lanes[1:], after[:1])))


def count_from(first):
    return _lanes(first + np.arange(WIDTH))


def to_int(lanes):
    return _lanes(lanes.astype(np.intp)) if np.ndim(lanes) else int(lanes)


def to_float(lanes):
    return _lanes(lanes.astype(float)) if np.ndim(lanes) else float(lanes)


def total(lanes):
    return sum(lanes.tolist())


def any_lane(mask):
    return bool(np.any(mask))


def select(mask, yes, no):
    return _lanes(np.where(mask, yes, no)) if np.ndim(mask) else (yes if mask else no)


square_root, absolute, with_sign = np.sqrt, np.abs, np.copysign


def fma(scalar, lanes, addend):
    return scalar * lanes + addend


def exponent_and_mantissa(lanes):
    mantissa, power = np.frexp(lanes)
    return power - 1.0, 2.0 * mantissa


def power_of_two(wholes):
    return np.ldexp(1.0, wholes)


def load(array, index):
    return _lanes(array.reshape(-1)[index : index + WIDTH].copy())


def store(array, index, lanes):
    array.reshape(-1)[index : index + np.size(lanes)] = lanes


def gather(array, at):
    return _lanes(array.reshape(-1)[at])


def gather_pair(array, at, apart):
    return gather(array, at), gather(array, at + apart)


def scatter_add(array, at, lanes):
    np.add.at(array.reshape(-1), at if np.ndim(at) else np.arange(at, at + WIDTH), lanes)


def gather_nodes(array, places, where, apart):
    at = [load(places, where + k * apart) for k in range(6)]
    return tuple(gather(array, i) for i in at), tuple(gather(array, i + apart) for i in at)


def add_at_places(array, places, where, apart, first, second):
    at = load(places, where)
    scatter_add(array, at, first)
    scatter_add(array, at + apart, second)


def gather_rows(array, places, where, offset):
    at = load(places, where) + offset
    return tuple(gather(array, at + k) for k in range(6))


def gather_quads(array, at):
    return tuple(gather(array, at + k) for k in range(4))


def add_to_rows(array, places, where, offset, six):
    at = load(places, where) + offset
    for k, lanes in enumerate(six):
        scatter_add(array, at + k, lanes)
