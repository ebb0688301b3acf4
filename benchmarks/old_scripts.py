"""Scripts of older MeshLab versions, upgraded and run: the source of the figures in docs/old_scripts.md.

    python benchmarks/old_scripts.py FOLDER [--timeout 150]

Each .mlx file in FOLDER is brought up to date and run on meshes that come with pymeshlab, one after another until it succeeds on
one; a bone is its second layer. Prints a line a script, with what was refused and why, and how many were upgraded, with the same
meaning, and run.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

import pymeshlab

from pymeshfair import MeshSet, Recipe
from pymeshfair.errors import PymeshfairError
from pymeshfair.scripts import ScriptError

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
#: a textured mesh, one with holes, one with colours, and a cloud
MESHES = ("bunny10k_textured.obj", "bone.ply", "colored_airplane.ply", "cloud.ply")


def verdict(path: Path, folder: Path, timeout: float) -> tuple[list[str], str]:
    """What holds of a script, of ``upgraded``, ``same meaning`` and ``run``, and a line about it."""
    try:
        recipe = Recipe.load(path, upgrade=True)
    except ScriptError as error:
        return [], f"refused: {error.problems[0]}"
    held = ["upgraded"] + ["same meaning"] * all(change.same_meaning for change in recipe.changes)
    why = ""
    for mesh in MESHES:
        source = folder / mesh if mesh == "cloud.ply" else SAMPLES / mesh
        try:
            result = recipe.run(source, folder / "out.ply", others=[SAMPLES / "bone.ply"], overwrite=True, timeout=timeout)
        except ScriptError as error:
            return held, f"refused: {error.problems[0]}"
        except PymeshfairError as error:
            why = why or f"fails on {mesh}: {error}"
            continue
        return [*held, "run"], f"{mesh}: {result.after['vertices']:,} vertices, {result.after['faces']:,} faces"
    return held, why


def main() -> int:
    """Run them all; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--timeout", type=float, default=150.0, metavar="SECONDS")
    options = parser.parse_args()
    scripts = sorted(options.folder.glob("*.mlx"))
    count: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        meshes = MeshSet()
        meshes.load_new_mesh(str(SAMPLES / "chameleon.pts"))
        meshes.save_current_mesh(str(folder / "cloud.ply"))
        for path in scripts:
            held, line = verdict(path, folder, options.timeout)
            count.update(held)
            print(f"{path.stem[:40]:<40}  {line}", flush=True)
    print(f"{len(scripts)} scripts, " + ", ".join(f"{count[word]} {word}" for word in ("upgraded", "same meaning", "run")))
    return 0


if __name__ == "__main__":
    sys.exit(main())
