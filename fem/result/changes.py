"""What two scenes, or two sets of versions, differ in, for messages."""

from collections.abc import Mapping

from lagrange.scene import Scene


def differences(before: Mapping[str, object], now: Mapping[str, object]) -> list[str]:
    """A phrase for each key whose values differ."""
    return [
        f"{key} was {before.get(key)!r}, now {now.get(key)!r}"
        for key in sorted(before | now)
        if before.get(key) != now.get(key)
    ]


def scene_keys(scene: Scene) -> dict[str, object]:
    """Values of a scene by their dotted keys."""
    return _flat(scene.model_dump())


def _flat(tables: dict, prefix: str = "") -> dict[str, object]:
    flat = {}
    for key, value in tables.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return flat
