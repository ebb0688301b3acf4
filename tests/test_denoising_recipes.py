"""The recipes that denoise, each on the kind of shape that it is for; shapes and measures are the benchmark's own."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pymeshlab
import pytest
from denoising_findings import Shape, bumpy_ball, chest
from numpy.typing import NDArray

from pymeshfair import MeshSet
from pymeshfair.recipe import load_recipe
from tests.meshes import grid

RECIPES = ("denoise", "denoise_meshlab_only")


@functools.cache
def box() -> Shape:
    """Sharp: 3,072 faces, noise of 0.3 mean edges."""
    return chest(16)


@functools.cache
def ball() -> Shape:
    """Smooth: 5,120 faces, the same noise."""
    return bumpy_ball(4)


@functools.cache
def range_map() -> Shape:
    """A hilly field of 4,050 triangles seen from above, with noise along the line of sight alone, in steps."""
    truth, faces = grid(45, 45)
    truth[:, 2] = 4 * np.sin(truth[:, 0] / 9) * np.cos(truth[:, 1] / 11)
    noisy = truth.copy()
    noisy[:, 2] = np.round((noisy[:, 2] + np.random.default_rng(7).normal(0, 0.3, len(truth))) / 0.25) * 0.25
    return Shape("field", truth, noisy, faces, np.zeros(len(faces), dtype=np.bool_))


def after(name: str, shape: Shape, meshes: pymeshlab.MeshSet | MeshSet | None = None) -> NDArray[np.float64]:
    """The vertices after the recipe, in a mesh set of ours or of pymeshlab's."""
    meshes = meshes or MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(shape.noisy, shape.faces))
    meshes.load_filter_script(str(load_recipe(name).script.path))
    meshes.apply_filter_script()
    return np.asarray(meshes.current_mesh().vertex_matrix())


def meshlab_error(shape: Shape, filter_name: str) -> float:
    """The error that one of MeshLab's filters leaves with its default values, degrees."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(shape.noisy, shape.faces))
    meshes.apply_filter(filter_name)
    return shape.mad(np.asarray(meshes.current_mesh().vertex_matrix()))


@pytest.mark.parametrize("name", RECIPES)
def test_every_parameter_is_written(name: str) -> None:
    """MeshLab's own reader fills nothing in, so each step says all."""
    for step in load_recipe(name).script.steps:
        assert set(step.values) == {p.name for p in step.filter.parameters}, step.filter.name


@pytest.mark.slow
@pytest.mark.parametrize("name", RECIPES)
def test_sharp_shapes_keep_their_edges(name: str) -> None:
    """Of the noise a fifth stays at most, less than half at the edges, and less than half of what Taubin smoothing leaves."""
    shape, found = box(), after(name, box())
    assert shape.mad(found) < min(shape.mad(shape.noisy) / 5, meshlab_error(shape, "apply_coord_taubin_smoothing") / 2)
    assert shape.mad_at_features(found) < shape.mad_at_features(shape.noisy) / 2


def test_smooth_shapes_keep_their_bumps() -> None:
    """The error is below that of MeshLab's Taubin filter and less than half of that of its two-step filter."""
    found = ball().mad(after("denoise", ball()))
    assert found < meshlab_error(ball(), "apply_coord_taubin_smoothing")
    assert found < meshlab_error(ball(), "apply_coord_two_steps_smoothing") / 2


@pytest.mark.slow
def test_range_maps_lose_their_steps() -> None:
    """Of noise in steps along the line of sight a third stays at most, and no more than the recipe for such maps alone left."""
    found = range_map().mad(after("denoise", range_map()))
    assert found < range_map().mad(range_map().noisy) / 3
    assert found <= range_map().mad(after("denoise_kinect", range_map()))


def test_the_chain_of_built_in_filters_does_the_same_in_plain_pymeshlab() -> None:
    """The recipe needs nothing of ours: pymeshlab alone gives the same coordinates to the bit."""
    assert all(step.filter.is_builtin for step in load_recipe("denoise_meshlab_only").script.steps)
    plain = after("denoise_meshlab_only", box(), pymeshlab.MeshSet())
    np.testing.assert_array_equal(after("denoise_meshlab_only", box()), plain)


def test_the_chain_of_built_in_filters_copes_with_vertices_that_no_face_uses() -> None:
    """MeshLab's two-step filter alone refuses them for lack of compactness; the recipe removes them first."""
    stray = replace(box(), noisy=np.concatenate([[[9.0, 9.0, 9.0]], box().noisy]), faces=box().faces + np.int32(1))
    np.testing.assert_array_equal(after("denoise_meshlab_only", stray), after("denoise_meshlab_only", box()))
