"""The command render-fem: pictures, films, exports, and what it says of unusable options."""

from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from fem.commands.render_fem import render_main
from fem.pictures.canvas import Panel


def test_the_command_writes_a_png_of_the_width_asked_for(coarse_run, tmp_path, capsys):
    target = tmp_path / "new folder" / "bearing.png"
    options = ["--time", "2", "--output", str(target), "--width", "400", "--magnification", "100"]
    assert render_main([str(coarse_run), *options]) == 0
    assert str(target) in capsys.readouterr().out
    with Image.open(target) as picture:
        assert picture.format == "PNG" and picture.size == (400, 300)


def _frames(path):
    """A GIF's frames as arrays."""
    with Image.open(path) as film:
        frames = []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB")))
        return frames, film.info


def test_pictures_name_model_and_damping(coarse_run, tmp_path, monkeypatch):
    """In the picture itself and in the text of its file, which the report takes for its caption."""
    said, text = [], Panel.text
    monkeypatch.setattr(Panel, "text", lambda panel, words, *where, **how: said.append(words) or text(
        panel, words, *where, **how))  # fmt: skip
    for view in ("bearing", "close-up"):
        target = tmp_path / f"{view}.png"
        assert render_main([str(coarse_run), "--output", str(target), "--width", "320", "--view", view]) == 0
        with Image.open(target) as image:
            assert image.text["Description"].endswith("; finite elements, no contact damping.")
        assert any("finite elements, no contact damping" in words for words in said)
        said.clear()


def test_a_gif_has_the_frames_asked_for_each_another_and_the_same_each_time(coarse_run, tmp_path, capsys):
    films = [tmp_path / "a.gif", tmp_path / "b.gif"]
    for film in films:
        options = ["--animation", str(film), "--frames", "4", "--fps", "10", "--width", "400", "--quiet"]
        assert render_main([str(coarse_run), *options]) == 0
    assert "4 frames" in capsys.readouterr().out
    assert films[0].read_bytes() == films[1].read_bytes()
    frames, info = _frames(films[0])
    assert np.all(frames[0][5, 5] == 255) and np.all(frames[-1][290, 5] == 255)  # white stays white
    assert len(frames) == 4 and info["duration"] == 100 and frames[0].shape == (300, 400, 3)
    assert all((a != b).any() for a, b in pairwise(frames))
    # the scale beside the bearing stands still
    assert all(np.array_equal(frame[45:108, 275:310], frames[0][45:108, 275:310]) for frame in frames)


def test_an_mp4_has_the_frames_asked_for(coarse_run, tmp_path):
    import imageio_ffmpeg

    film = tmp_path / "film.mp4"
    options = ["--animation", str(film), "--start", "1", "--stop", "2", "--frames", "3", "--width", "402"]
    assert render_main([str(coarse_run), *options, "--view", "close-up", "--quiet"]) == 0
    frames = imageio_ffmpeg.read_frames(str(film))
    told = next(frames)
    images = [np.frombuffer(frame, dtype=np.uint8).reshape(302, 402, 3) for frame in frames]
    assert told["size"] == (402, 302) and told["fps"] == 25.0 and len(images) == 3
    assert images[0][:20].mean() > 200 and images[0].std() > 20  # the title's white, and a picture


def test_a_film_that_fails_leaves_nothing(coarse_run, tmp_path, monkeypatch):
    from fem.pictures.render import Renderer

    def fail(self, sample):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Renderer, "image", fail)
    assert render_main([str(coarse_run), "--animation", str(tmp_path / "film.gif"), "--frames", "3", "--quiet"]) == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "options, words",
    [
        (["--time", "99"], "0 to 4 ms"),
        (["--width", "10"], "--width 10"),
        (["--magnification", "-1"], "--magnification -1"),
        (["--magnification", "nan"], "--magnification nan"),
        (["--output", "."], "is a folder"),
        (["--animation", "film.avi"], "must end in .mp4 or .gif"),
        (["--export", "mesh.stl"], "must end in .vtkhdf, .csv, .wav or a format of meshio: .vtu"),
        (["--animation", "film.mp4", "--export", "mesh.vtu"], "give only one of them"),
        (["--animation", "film.mp4", "--time", "1"], "--time: not for a film"),
        (["--start", "1"], "--start, --stop, --frames: only for a film"),
        (["--animation", "film.mp4", "--start", "3", "--stop", "2"], "3 to 2 ms contain no sample"),
        (["--animation", "film.mp4", "--frames", "1"], "--frames 1"),
    ],
)
def test_unusable_options_exit_2_in_a_sentence(coarse_run, capsys, options, words):
    assert render_main([str(coarse_run), *options]) == 2
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told
