"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects.

`Scene`, `read_scene` and what else users import is loaded when first used; tables of the scene stand in the modules.
"""


def __getattr__(name: str):
    from lagrange.scene import scene

    return getattr(scene, name)
