"""The LoOP filter as MeshLab users meet it: its names, bounds and help, and the edit that it returns."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, cast

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair import MeshSet
from pymeshfair.declaration import Edit, FilterClass, Float, Int, Layer, MeshElement
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.outliers.local_outlier_probability import local_outlier_probability
from pymeshfair.mesh_data import MeshData
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.plugins.outliers import compute_selection_by_outlier_probability_per_vertex as declared
from pymeshfair.registry import find_filter
from pymeshfair.running.document import Document
from pymeshfair.scripts.script import Step
from tests.meshes import grid, icosphere, spiral


@dataclass
class Points:
    """As much of a layer as the filter reads."""

    vertices: NDArray[np.float64]
    has_vertex_scalars = False


def apply(vertices: NDArray[np.float64], **values: Any) -> Edit:
    """The edit that the filter returns for these vertices, its parameters checked and completed as the host does."""
    assert declared.function is not None
    return declared.function(cast(Layer, Points(vertices)), **declared.with_defaults(values))


@pytest.fixture(scope="module")
def cloud() -> NDArray[np.float64]:
    """A spiral of 500 points evenly around a sphere, and one point in its centre, the last."""
    return np.concatenate([spiral(500), np.zeros((1, 3))])


def test_the_edit_has_probabilities_selection_and_numbers(cloud: NDArray[np.float64]) -> None:
    """The probabilities become the scalar, those above the threshold the selection; nothing else is edited."""
    edit = apply(cloud, neighbors=12, extent=2.0, threshold=0.3)
    probabilities = local_outlier_probability(cloud, neighbors=12, extent=2.0)
    assert edit.vertex_scalars is not None
    assert edit.vertex_selection is not None
    np.testing.assert_array_equal(edit.vertex_scalars, probabilities)
    np.testing.assert_array_equal(edit.vertex_selection, probabilities > 0.3)
    assert edit.values == {
        "selected_vertices": np.count_nonzero(probabilities > 0.3),
        "largest_probability": probabilities[-1],
        "mean_probability": probabilities.mean(),
    }
    touched = {f.name for f in fields(edit) if getattr(edit, f.name) is not None and f.name not in ("new_layers", "notes")}
    assert touched == {"vertex_scalars", "vertex_selection", "values"}


def test_the_defaults_select_the_point_in_the_centre_alone(cloud: NDArray[np.float64]) -> None:
    """20 neighbours, extent 3 and threshold 0.5 find the one stray point of a sphere."""
    edit = apply(cloud)
    assert edit.vertex_selection is not None
    assert np.flatnonzero(edit.vertex_selection).tolist() == [500]
    assert {p.name: p.default for p in declared.parameters} == {"neighbors": 20, "extent": 3.0, "threshold": 0.5}


def test_thresholds_at_the_ends(cloud: NDArray[np.float64]) -> None:
    """As the help says, a threshold of 1 selects nothing and one of 0 every vertex of positive probability."""
    assert apply(cloud, threshold=1.0).values["selected_vertices"] == 0
    positive = np.count_nonzero(local_outlier_probability(cloud) > 0.0)
    assert apply(cloud, threshold=0.0).values["selected_vertices"] == positive > 100


def test_too_small_a_cloud_is_refused() -> None:
    """A cloud of fewer points than neighbours is refused with both numbers; so is an empty one."""
    with pytest.raises(FilterInputError, match="20 neighbours need a cloud of at least 21 points, got 3"):
        apply(np.eye(3))
    with pytest.raises(FilterInputError, match="at least 21 points, got 0"):
        apply(np.empty((0, 3)))


def test_the_declaration_mirrors_meshlabs() -> None:
    """The registry knows the filter by both names, no filter of MeshLab has either, and the dialog gets MeshLab's types."""
    assert find_filter(declared.python_name).python_name == declared.python_name
    assert find_filter("Select Outliers by Probability (LoOP)").python_name == declared.python_name
    taken = {name for known in meshlab_filters() for name in (known.name, known.python_name)}
    assert not {declared.name, declared.python_name} & taken
    assert declared.classes == FilterClass.SELECTION | FilterClass.CLEANING | FilterClass.POINT_SET
    assert declared.changes == MeshElement.VERTQUALITY | MeshElement.VERTFLAGSELECT
    assert declared.references == ("kriegel2009",)
    neighbors, extent, threshold = declared.parameters
    assert isinstance(neighbors, Int)
    assert isinstance(extent, Float)
    assert isinstance(threshold, Float)
    assert [p.xml_type for p in declared.parameters] == ["RichInt", "RichFloat", "RichDynamicFloat"]
    assert (neighbors.minimum, extent.minimum, threshold.minimum, threshold.maximum) == (1, 0.1, 0, 1)


def test_copies_among_stray_points_are_told() -> None:
    """Of a sheet whose points are there five times each nearly all pass for clumps, and a note says why; without copies none."""
    sheet = np.stack(np.meshgrid(np.arange(30.0), np.arange(30.0), [0.0]), axis=-1).reshape(-1, 3)
    for times, lines in ((5, 2), (1, 0)):
        meshes, notes = MeshSet(), list[str]()
        meshes.on_note = notes.append
        meshes.add_mesh(pymeshlab.Mesh(np.repeat(sheet + 0.1 * np.random.default_rng(0).normal(size=sheet.shape), times, axis=0)))
        meshes.compute_selection_by_stray_points_per_vertex()
        assert len(notes) == lines
        assert all("remove duplicate vertices first" in note for note in notes[1:])


def test_stray_points_of_a_mesh_are_refused_where_clouds_are_meant() -> None:
    """With `clouds_only` a mesh is refused and recipes for it are named; without, its faces play no part."""
    vertices, faces = icosphere(3)
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"a mesh, not a point cloud \(faces: 1,280\),.*'clean_range_map'"):
        meshes.compute_selection_by_stray_points_per_vertex(clouds_only=True)
    assert meshes.compute_selection_by_stray_points_per_vertex() == {"selected_vertices": 0}
    meshes.add_mesh(pymeshlab.Mesh(np.concatenate([vertices, [[5.0, 0.0, 0.0]]])))
    assert meshes.compute_selection_by_stray_points_per_vertex(clouds_only=True) == {"selected_vertices": 1}
    assert meshes.current_mesh().vertex_selection_array().tolist() == [False] * len(vertices) + [True]


def test_the_points_of_each_kind_are_counted_in_words(cloud: NDArray[np.float64], tmp_path: Path) -> None:
    """The point in the centre of a spiral round a ball is part of no surface and an outlier; nothing is said where none is."""
    said: list[str] = []
    document = Document(tmp_path, on_note=said.append)
    for vertices in (cloud, cloud[:-1]):
        document.add(MeshData(vertices=vertices))
        for name, values in (("stray_points", {}), ("outlier_probability", {"threshold": 0.9})):
            document.apply(Step(find_filter(f"compute_selection_by_{name}_per_vertex")).with_values(values))
    assert said == [
        "1 of 501 points are part of no surface: alone, in a haze, or in small clumps",
        "1 of 501 points are outliers with a probability above 0.9",
    ]


@pytest.mark.parametrize("size", [1.0, 1e-160, 1e160])
def test_the_share_of_a_mesh_that_no_point_supports_is_said(tmp_path: Path, size: float) -> None:
    """Of a strip of 12 by 1 cells over a cloud of its first 8 columns a third is far; the message says so in any unit."""
    x, y = (a.ravel().astype(float) for a in np.meshgrid(np.arange(8), np.arange(-3, 5), indexing="ij"))
    vertices, faces = grid(1, 12)
    said: list[str] = []
    document = Document(tmp_path, on_note=said.append)
    document.add(MeshData(vertices=size * np.column_stack([x, y, np.zeros(64)])))
    document.add(MeshData(vertices=size * vertices, faces=faces))
    document.apply(Step(find_filter("compute_selection_by_distance_from_cloud_per_vertex")).with_values({"spacings": 1.5}))
    assert said == [
        "33.33% of the area is farther than 1.5 spacings from every point, and selected; "
        "another 8.33% is farther than 0.75, and stays: it may bridge gaps",
        "50.00% of the points have no surface within 1.5 spacings: a larger reconstruction depth keeps details",
    ]


def test_scalars_that_the_probabilities_replace_are_named(tmp_path: Path) -> None:
    """A note says that a scanner's scalars are replaced; where all are 0, or there are none, nothing is said."""
    vertices = icosphere(2)[0]
    step, notes = Step(find_filter(declared.python_name)), list[list[str]]()
    for k, scalars in enumerate((np.arange(len(vertices), dtype=float), np.zeros(len(vertices)), None)):
        found: list[str] = []
        document = Document(tmp_path / str(k), on_note=found.append)
        document.add(MeshData(vertices=vertices, vertex_attributes={} if scalars is None else {"scalars": scalars}))
        document.apply(step.with_defaults())
        notes.append(found[1:])  # the first counts the outliers
    assert notes == [["the outlier probabilities replace the vertex scalars of the mesh"], [], []]
