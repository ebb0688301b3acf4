"""Where a mesh lies, how it is turned, how large it is and how it is numbered makes no difference."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pymeshfair.declaration import MeshElement
from tests.contracts.scenes import Outcome, Scene, apply, scene_for
from tests.contracts.variants import Variant, each_variant, outcome_of
from tests.meshes import Floats, diagonal, rotation

EPS = 2.0**-52
#: what a few hundred roundings of numbers of the size of the mesh add up to
ROUNDINGS = 256 * EPS
#: a small random shift, in diagonals, by which it is measured how roundings are amplified
NUDGE = 2.0**-30
#: one step of a colour that MeshLab keeps in eight bits
SHADE = 1 / 255

#: the power of length that a reported value goes with, by name, or by name and choice; 0 for those not named
POWERS: dict[str | tuple[str, str | None], int] = {
    "area": 2,
    "detail_size": 1,
    "eigenvalue": -2,
    "energies": 2,
    "energy": 2,
    "frequencies": -1,
    "frequency": -1,
    "height": 1,
    "largest_displacement": 1,
    "largest_size": 1,
    "mean_edge": 1,
    "time_step": 2,
    ("time_step", "operator=inverse_length"): 0,
    ("time_step", "operator=uniform"): 0,
    "wavelength": 1,
    "weight": -4,
}
#: the power of length that scalars go with, and every number that is reported beside them, by filter; 0 for those not named
SCALAR_POWERS = {
    "compute_scalar_by_displacement_per_vertex": 1,
    "compute_scalar_by_gaussian_curvature_per_vertex": -2,
    "compute_scalar_by_mean_curvature_per_vertex": -1,
}
#: choices with which they go with none
WITHOUT_UNIT = {"measure=deficit"}
#: filters that take a direction in space
BY_DIRECTION = {"compute_color_by_reflection_lines_per_vertex"}
#: reported values that are roundings themselves, or bounds of errors
OF_ERRORS = {"backward_error", "error", "last_correction", "refinements"}
#: reported values that belong to the axes or to a unit: the box, and bands at frequencies that are the same for every mesh
OF_A_FRAME = {"band_edges", "band_energies", "diagonal"}
#: reported values that are measured on the coordinates of the result, after their last rounding
OF_THE_RESULT = {"drift", "height", "largest_displacement", "triangle_quality_after"}
#: to what share of the diagonal a filter's coordinates are solved for: 1e-10 in the mean of all vertices; to a millionth of steps
#: that are half an edge long at most; low passes to 1e-12, a gain and two differences away
SOLVED_TO = {
    "apply_coord_bilaplacian_smoothing": 1e-10,
    "apply_coord_detail_enhancement": 1e-11,
    "apply_coord_implicit_fairing": 1e-9,
    "apply_coord_tangential_smoothing": 1e-6,
}
#: filters that count from the vertex with the lowest number: the rows of a neck from the rim that comes first
BY_NUMBER = {"meshing_bridge_rims_by_fairing"}


@dataclass(frozen=True)
class Similarity:
    """A scene moved, turned, scaled and renumbered: ``size * rotation @ p + shift`` for every vertex p."""

    rotation: Floats
    shift: Floats
    size: float
    order: NDArray[np.intp]
    face_order: NDArray[np.intp]

    def of(self, scene: Scene) -> Scene:
        vertices = self.size * scene.vertices @ self.rotation.T + self.shift
        return replace(scene, vertices=vertices).renumbered(self.order, self.face_order)

    def undone(self, found: Outcome, variant: Variant) -> Outcome:
        """The outcome on the scene as it was; vertices and faces that were added come last in any order."""
        n, m = len(self.order), len(self.face_order)
        vertex_at = np.concatenate([np.argsort(self.order), np.arange(n, len(found.vertices))])
        face_at = np.concatenate([np.argsort(self.face_order), np.arange(m, len(found.arrays["faces"]))])
        arrays = {
            name: array[vertex_at if name.startswith("vert") else face_at]
            for name, array in found.arrays.items()
            if name != "edges"
        }
        old = np.concatenate([self.order, np.arange(n, len(found.vertices))])
        arrays["faces"] = old[arrays["faces"]]
        arrays["vertices"] = (arrays["vertices"] - self.shift) / self.size @ self.rotation
        arrays["face_normals"] = arrays["face_normals"] @ self.rotation
        choice = variant.choice
        scalars = 0 if choice in WITHOUT_UNIT else SCALAR_POWERS.get(variant.declared.python_name, 0)
        arrays["vertex_scalars"] = arrays["vertex_scalars"] / self.size**scalars
        powers = {name: POWERS.get((name, choice), POWERS.get(name, scalars)) for name in found.values}
        values = {name: _divided(value, self.size ** powers[name]) for name, value in found.values.items()}
        return Outcome(arrays, values)


def unmoved(scene: Scene) -> Similarity:
    """The similarity that leaves the scene as it is."""
    return Similarity(np.eye(3), np.zeros(3), 1.0, np.arange(len(scene.vertices)), np.arange(len(scene.faces)))


@each_variant
def test_a_million_diagonals_away_nothing_is_lost(variant: Variant) -> None:
    """The result moves along, exact but for the roundings of its own coordinates: 2^-32 of a diagonal are lost there alone.

    The coordinates of the scene lie on a grid, so that those of the moved one are exact. Those of the result are rounded when
    they are put back there; new vertices also when they are made, and when they are moved.
    """
    scene = scene_for(variant.declared)
    there = replace(unmoved(scene), shift=np.array([2.0**20, -(2.0**19), 2.0**18]) * np.ceil(diagonal(scene.vertices)))
    assert (there.of(scene).vertices - there.shift == scene.vertices).all()
    found = there.undone(apply(variant.declared, there.of(scene), variant.values), variant)
    assert_agree(variant, found, last=3 * float(np.spacing(np.abs(there.shift).max())) / 2)


@each_variant
def test_a_turned_scaled_and_renumbered_mesh_has_the_same_result(variant: Variant) -> None:
    """To rounding: the coordinates that come in are rounded once, which is amplified as any other change of them is."""
    scene = scene_for(variant.declared)
    rng = np.random.default_rng(5)
    there = Similarity(
        rotation(1),
        np.array([3.0, -1.0, 2.0]),
        3.7,
        rng.permutation(len(scene.vertices)),
        rng.permutation(len(scene.faces)),
    )
    if variant.declared.python_name in BY_NUMBER:
        there = replace(there, order=np.arange(len(scene.vertices)))
    if variant.declared.python_name in BY_DIRECTION:
        there = replace(there, rotation=np.eye(3))
    found = there.undone(apply(variant.declared, there.of(scene), variant.values), variant)
    assert_agree(variant, found)


@each_variant
def test_a_power_of_two_changes_no_bit(variant: Variant) -> None:
    """A scene 2^40 times as large, whose coordinates have the same digits, has a result of the same digits."""
    scene = scene_for(variant.declared)
    there = replace(unmoved(scene), size=2.0**40)
    found = there.undone(apply(variant.declared, there.of(scene), variant.values), variant)
    expected = outcome_of(variant)
    assert set(found.differences(expected)) <= {"edges"} | OF_ERRORS | OF_A_FRAME


def assert_agree(variant: Variant, found: Outcome, *, last: float = 0.0) -> None:
    """Every array and number agrees with what comes of the scene itself, to what roundings explain.

    Args:
        variant: the way to call the filter.
        found: the outcome, moved back to where the scene is.
        last: an error of coordinates that is made after the filter, in mesh units.
    """
    expected = outcome_of(variant)
    unit = diagonal(scene_for(variant.declared).vertices)
    solved = SOLVED_TO.get(variant.declared.python_name, 0.0) * unit + expected.values.get("error", 0.0)
    for name, shift in _shifts(variant, found, expected).items():
        allowed = ROUNDINGS * unit * amplification(variant)[name] + (SHADE if name == "vertex_colors" else 0.0)
        if name in {"vertices"} | OF_THE_RESULT:
            allowed += solved + last
        assert shift <= allowed, f"{name}: {shift:.3g} > {allowed:.3g}"
    exact = [
        {k: v for k, v in o.values.items() if not _is_number(v) and k not in OF_ERRORS | OF_A_FRAME} for o in (found, expected)
    ]
    assert _alike(*exact)
    if len(found.vertices) == len(scene_for(variant.declared).vertices):
        assert _triangles(found) == _triangles(expected)


def _alike(found: Any, expected: Any) -> bool:
    """Whether words are the same, and numbers within lists, such as the errors of what was tried, to a few roundings."""
    if isinstance(found, Mapping) and isinstance(expected, Mapping):
        return found.keys() == expected.keys() and all(_alike(found[key], expected[key]) for key in found)
    if isinstance(found, list) and isinstance(expected, list):
        return len(found) == len(expected) and all(map(_alike, found, expected))
    if isinstance(found, float) and isinstance(expected, float):
        return math.isclose(found, expected, rel_tol=1e-9, abs_tol=1e-12)
    return bool(found == expected)


@functools.cache
def amplification(variant: Variant) -> dict[str, float]:
    """By how much each array and number moves if every coordinate moves by 1: of a small random shift, at least 1."""
    scene = scene_for(variant.declared)
    size = NUDGE * diagonal(scene.vertices)
    shift = np.random.default_rng(3).uniform(-size, size, scene.vertices.shape)
    nudged = apply(variant.declared, replace(scene, vertices=scene.vertices + shift), variant.values)
    return {name: max(1.0, moved / size) for name, moved in _shifts(variant, nudged, outcome_of(variant)).items()}


def _shifts(variant: Variant, found: Outcome, expected: Outcome) -> dict[str, float]:
    """How far arrays and numbers of two outcomes lie apart, by name."""
    n = len(scene_for(variant.declared).vertices)
    names = ["vertex_scalars", "vertex_colors"]
    if not variant.declared.changes & (MeshElement.VERTCOORD | MeshElement.FACENUMBER):
        names.append("face_normals")  # elsewhere MeshLab computes them of coordinates that are rounded
    both = [{name: o.arrays[name][:n] if name != "face_normals" else o.arrays[name] for name in names} for o in (found, expected)]
    for outcome, arrays in zip((found, expected), both, strict=True):
        arrays |= {
            k: np.asarray(v, float) for k, v in outcome.values.items() if _is_number(v) and k not in OF_ERRORS | OF_A_FRAME
        }
    assert both[0].keys() == both[1].keys()
    shifts = {name: _furthest(both[0][name], both[1][name]) for name in both[0]}
    shifts["vertices"] = _furthest(found.vertices[:n], expected.vertices[:n])
    if len(expected.vertices) > n:
        added = [o.vertices[n:] for o in (found, expected)]
        assert len(added[0]) == len(added[1])
        way = max(cKDTree(added[k]).query(added[1 - k], p=np.inf)[0].max() for k in (0, 1))
        shifts["vertices"] = max(shifts["vertices"], float(way))
    return shifts


def _furthest(found: NDArray[Any], expected: NDArray[Any]) -> float:
    """The largest difference of two arrays, NaN and infinities in the same places aside."""
    assert found.shape == expected.shape
    alike = (found == expected) | (np.isnan(found) & np.isnan(expected))
    return (
        float(np.abs(np.where(alike, 0.0, found - np.where(alike, 0.0, expected))).max(initial=0.0)) if not alike.all() else 0.0
    )


def _divided(value: Any, by: float) -> Any:
    if not _is_number(value) or by == 1.0:
        return value
    return (np.asarray(value, float) / by).tolist()


def _is_number(value: Any) -> bool:
    """Whether a reported value is a float or a list of floats."""
    return isinstance(value, float) or (isinstance(value, list | tuple) and any(isinstance(x, float) for x in value))


def _triangles(outcome: Outcome) -> set[tuple[int, ...]]:
    return {tuple(row) for row in np.sort(outcome.arrays["faces"], axis=1).tolist()}
