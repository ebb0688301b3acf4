"""How `denoise` does at the borders of open meshes, next to them and inside.

    python benchmarks/denoising_borders.py [--only text,text]

Cuts shapes of `denoising_pairs.py` open along the edges of their faces, adds noise, and prints the mean angle to the true normals
for the faces with a vertex on the border, for those next to them, and for all others; and how far border vertices are from their
true places, in mean edges.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
from denoising_holdouts import SAMPLES, lens, part, taken, torus
from denoising_metrics import Floats, Ints, angles_to_truth, used_alone
from denoising_pairs import NOISES, Maker, blobs, terrain

from pymeshfair.filters.denoising.automatic import denoise_automatically
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import border_vertices


def cut(make: Maker, normal: tuple[float, float, float], share: float) -> Maker:
    """The faces on one side of a plane, which is so large a share of the size from the middle."""

    def made() -> tuple[Floats, Ints]:
        vertices, faces = make()
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        heights = (vertices[faces].mean(axis=1) - (low + high) / 2.0) @ (np.array(normal) / np.linalg.norm(normal))
        return used_alone(faces[heights < share * (high - low).max()], vertices)

    return made


SHAPES: dict[str, Maker] = {
    "terrain": terrain,
    "lens": cut(lens, (0.3, 1.0, 0.2), 0.15),
    "bunny": cut(lambda: taken(SAMPLES / "bunny10k_textured.obj"), (1.0, 0.2, 0.1), 0.12),
    "cow": cut(lambda: taken(SAMPLES / "cow.obj", edge=1.0), (0.1, 0.2, 1.0), 0.0),
    "bracket": cut(lambda: part(True), (1.0, 0.3, 0.2), 0.2),
    "torus": cut(torus, (1.0, 0.3, 0.5), 0.2),
    "blobs": cut(blobs, (0.2, 1.0, 0.3), 0.1),
}
LEVELS = ("n1", "n3", "a2", "i8")


def split(vertices: Floats, truth: Floats, faces: Ints) -> list[float]:
    """The mean angles at the border, next to it and inside, and the displacement of border vertices."""
    on_border = border_vertices(faces, len(truth))
    at_border = on_border[faces].any(axis=1)
    reached = np.zeros_like(on_border)
    reached[faces[at_border]] = True
    near = reached[faces].any(axis=1)
    parts = (at_border, near & ~at_border, ~near)
    moved = np.linalg.norm((vertices - truth)[on_border], axis=1).mean() / mean_edge_length(truth, faces)
    return [*(float(angles_to_truth(vertices, truth, faces[which])[0].mean()) for which in parts), float(moved)]


def main() -> int:
    """Make, denoise and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    only = parser.parse_args().only.split(",")
    print("mesh           border   next inside  displacement")
    for shape, make in SHAPES.items():
        names = [f"{shape}_{level}" for level in LEVELS if any(text in f"{shape}_{level}" for text in only)]
        if names:
            truth, faces = make()
        for name in names:
            noisy = NOISES[name.rsplit("_", 1)[1]](truth, faces, np.random.default_rng(7))
            result, _ = denoise_automatically(noisy, faces)
            angles = split(result, truth, faces)
            print(f"{name:12} {angles[0]:8.2f} {angles[1]:6.2f} {angles[2]:6.2f}  {angles[3]:12.3f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
