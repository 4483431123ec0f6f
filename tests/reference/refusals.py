"""What scenes are refused with."""

from collections.abc import Sequence

import pytest

from lagrange.scene.scene import SceneError, parse_scene, parse_scene_text, read_scene


def refusal(given: dict | str | Sequence[str]) -> str:
    """The sentences with which a scene's tables, its TOML text, or settings as of --set are refused."""
    with pytest.raises(SceneError) as caught:
        if isinstance(given, dict):
            parse_scene(given, "scene.toml")
        elif isinstance(given, str):
            parse_scene_text(given, "scene.toml")
        else:
            read_scene(None, tuple(given))
    return str(caught.value)


def assert_refused(given: dict | str | Sequence[str], *words: str) -> None:
    """A scene is refused with words that name what is wrong."""
    told = refusal(given)
    assert all(word in told for word in words), told
