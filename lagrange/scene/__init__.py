"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects.

`Scene`, `read_scene` and what else users import is loaded when first used; tables of the scene stand in the modules.
"""

from importlib import import_module

__all__ = ["Scene", "read_scene"]


def __getattr__(name: str):
    if name not in __all__:
        raise AttributeError(f"module 'lagrange.scene' has no attribute {name!r}")
    return getattr(import_module("lagrange.scene.scene"), name)
