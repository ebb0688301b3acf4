"""A program with every entry of README's section on Python: type checkers find the ten errors of the comments and nothing else.

It is checked by `mypy` and by ``pyright tests/typing`` in strict mode, and is not run.
"""

from pathlib import Path

import numpy as np

import pymeshfair
from pymeshfair import MeshSet, PercentageValue, PureValue, Recipe
from pymeshfair.filters.diffusion import implicit_fairing


def clean(scan: Path) -> float:
    """Each entry as the README has it."""
    ms = MeshSet()
    ms.load_new_mesh(str(scan))
    ms.meshing_remove_duplicate_vertices()
    ms.apply_coord_implicit_fairing(detail_size="6edge")
    ms.apply_coord_implicit_fairing(detail_size=PercentageValue(1))
    ms.meshing_isotropic_explicit_remeshing(iterations=3, targetlen=PureValue(0.5))
    ms.apply_recipe("fill_holes_smoothly")
    reports = ms.apply_recipe("denoise_meshlab_only", rounds=2)
    ms.save_filter_script("recipe.mlx")
    ms.save_current_mesh("clean.ply", save_textures=False)
    mesh = ms.current_mesh()
    count: int = mesh.vertex_number() + mesh.face_number()
    high = bool(mesh.vertex_matrix()[:, 2].max() > mesh.bounding_box().diagonal())
    measures = ms.get_surface_measures()
    vertices = int(measures["vertices"])
    for layer in ms:
        layer.set_label(f"{layer.label()} {len(reports)}")
    ms.add_mesh(ms.to_trimesh(), "again")
    smooth = implicit_fairing(mesh.vertex_matrix(), mesh.face_matrix(), time_step=0.3)
    return float(np.abs(smooth).max()) + count + vertices + high


def recipes(scan: Path) -> str:
    """A recipe that is built by the same methods, and a run in one call."""
    recipe = Recipe("mine", "Mine")
    size = recipe.setting("detail_size", "6edge", unit="mean edges")
    recipe.apply_coord_implicit_fairing(detail_size=size)
    recipe.limit(max_displacement="5%")
    recipe.save("mine.mlx")
    try:
        result = pymeshfair.run("clean_range_map", scan, "clean.ply", settings={"detail_size": "4edge"})
        result = recipe.run(scan, "mine.ply", overwrite=True)
    except pymeshfair.errors.UnknownNameError as error:
        return str(error)
    except pymeshfair.PymeshfairError as error:
        return str(error)
    return f"{result.output} {result.after['volume']} {result.warnings} {pymeshfair.__version__}"


def planted(ms: MeshSet, recipe: Recipe, scan: Path) -> None:
    """Ten errors, each found by both checkers."""
    ms.meshing_close_hole()  # type: ignore[attr-defined]  # pyright: ignore[reportUnknownMemberType, reportAttributeAccessIssue]
    ms.meshing_close_holes(maxholesiz=30)  # type: ignore[call-arg]  # pyright: ignore[reportCallIssue]
    ms.meshing_close_holes(maxholesize="many")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    ms.apply_coord_implicit_fairing(detail_size=6)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    ms.apply_coord_taubin_fairing(operator="uniforn")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    ms.load_new_mesh(3)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    ms.current_mesh().vertex_count()  # type: ignore[attr-defined]  # pyright: ignore[reportUnknownMemberType, reportAttributeAccessIssue]
    recipe.apply_coord_implicit_fairng()  # type: ignore[attr-defined]  # pyright: ignore[reportUnknownMemberType, reportAttributeAccessIssue]
    pymeshfair.run("denoise", scan)  # type: ignore[call-arg]  # pyright: ignore[reportCallIssue]
    pymeshfair.Meshset()  # type: ignore[attr-defined]  # pyright: ignore[reportUnknownMemberType, reportAttributeAccessIssue]
