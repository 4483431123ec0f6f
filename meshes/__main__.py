"""Re-make the meshes shipped with the package: the built-in scene's default and coarse ones."""

from pathlib import Path

from lagrange.scene.scene import read_scene
from meshes.bearing import bearing_shapes
from meshes.cache import file_name, write
from meshes.shapes import make

SHIPPED_SIZES_MM = (1.0, 2.0)


def main() -> None:
    folder = Path(__file__).parent / "data"
    bearing = read_scene().ideal_bearing()
    kept = set()
    for size in SHIPPED_SIZES_MM:
        shapes = bearing_shapes(bearing, 1e-3 * size)
        for shape in (shapes.roller, shapes.inner_ring, shapes.outer_ring):
            write(folder / file_name(shape), make(shape))
            kept.add(file_name(shape))
            print(f"{file_name(shape)}  {shape}")
    for old in folder.glob("*.npy"):
        if old.name not in kept:
            old.unlink()


if __name__ == "__main__":
    main()
