"""Parts of kernels are compiled for the fields that they use, whatever else their arguments hold."""

import importlib
from typing import NamedTuple

import numpy as np
import pytest
from numba.core.event import install_recorder

from fem.kernels.fields_used import WHOLE, fields_used, shifted
from fem.kernels.jit import KernelCache, PartCache, every, kernel, part, verb


class Wheel(NamedTuple):
    speed: np.ndarray
    radius: float


class Brake(NamedTuple):
    force: float


class Car(NamedTuple):
    wheel: Wheel
    brake: Brake | None
    load: np.ndarray | None = None


@verb
def slow(brake, speed):
    """Brakes slow a wheel."""


@slow.of(Brake)
def _slow(brake, speed):
    speed[0] -= brake.force


@part
def radius_of(wheel):
    return wheel.radius


@part
def drive(car, more):
    wheel, brake = car.wheel, car.brake
    turning = wheel.speed
    turning[0] += more / radius_of(wheel)
    slow(brake, turning)
    return brake is None


@part
def keep_all(car):
    return car


@part
def drive_one(car, more):
    drive(car, more)


drive_all = every(drive_one)


@part
def brake_all(cars, more):
    """Field of a field, entry of a tuple, name for either: what is absent is not compiled."""
    (car,), loads = cars, (cars[0].load, None)
    load = loads[0] if loads[0] is not None else loads[1]
    if car.brake is not None and more > 0.0:
        car.wheel.speed[0] -= car.brake.force
    if load is None:
        car.wheel.speed[0] += 1.0
    else:
        car.wheel.speed[0] += load[0]


@pytest.mark.parametrize(
    ("function", "used"),
    [
        (radius_of, ({"radius": WHOLE},)),
        (drive, ({"wheel": {"speed": WHOLE, "radius": WHOLE}, "brake": {"force": WHOLE}}, WHOLE)),
        (keep_all, (WHOLE,)),
        (_slow, ({"force": WHOLE}, WHOLE)),
        (drive_all, (WHOLE, WHOLE)),
    ],
)
def test_fields_that_a_part_uses_itself_or_by_parts_that_it_calls(function, used):
    assert fields_used(function) == used


def test_a_part_is_compiled_once_for_arguments_that_differ_in_what_it_does_not_use(monkeypatch):
    monkeypatch.setattr("fem.kernels.jit.cache_folder", lambda: None)

    @kernel
    def advance(cars, more):
        drive_all(cars, more)

    with install_recorder("numba:compile") as compiled:
        for brake, load, speed in ((None, None, 4.0), (Brake(1.0), None, 3.0), (Brake(1.0), np.zeros(2), 3.0)):
            car = Car(Wheel(np.zeros(1), 0.5), brake, load)
            advance(((car,),), 2.0)
            assert car.wheel.speed[0] == speed
    begun = [event.data["dispatcher"].py_func.__name__ for _, event in compiled.buffer if event.is_start]
    assert (begun.count("advance"), begun.count("drive"), begun.count("radius_of")) == (3, 2, 1)
    written = [code for code in shifted if code.__name__ == "code"]  # for groups, and kept as of the part's module
    assert written and all(importlib.import_module(code.__module__) for code in written)


def test_what_is_kept_of_a_part_and_of_a_kernel_of_one_function_has_files_of_its_own(tmp_path):
    key = "any", "key"
    assert PartCache(radius_of, tmp_path)._file(key) != KernelCache(radius_of, tmp_path)._file(key)


@pytest.mark.parametrize(("brake", "load", "speed"), [(None, None, 1.0), (Brake(2.0), np.full(1, 5.0), 3.0)])
def test_one_function_serves_scenes_with_a_part_and_without_it(monkeypatch, brake, load, speed):
    monkeypatch.setattr("fem.kernels.jit.cache_folder", lambda: None)

    @kernel
    def advance(cars, more):
        brake_all(cars, more)

    car = Car(Wheel(np.zeros(1), 0.5), brake, load)
    advance((car,), 1.0)
    assert car.wheel.speed[0] == speed


def test_a_question_that_the_reader_of_fields_does_not_see_is_no_silent_no(monkeypatch):
    monkeypatch.setattr("fem.kernels.jit.cache_folder", lambda: None)
    monkeypatch.setattr("fem.kernels.part_compiler.fields_used", lambda function: ({"wheel": WHOLE},))

    @part
    def is_free(car):
        return car.brake is None

    @kernel
    def ask(car):
        return is_free(car)

    with pytest.raises(TypeError, match="fields_used does not see"):
        ask(Car(Wheel(np.zeros(1), 0.5), None))
