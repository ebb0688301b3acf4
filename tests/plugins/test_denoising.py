"""Normal filtering as MeshLab users meet it: what is automatic, what is given, and the edit that comes back."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, cast
from unittest import mock

import numpy as np
import pytest

from pymeshfair.declaration import Bools, Edit, Filter, Layer
from pymeshfair.filters.denoising import (
    FIXED,
    NOTHING_TO_REMOVE,
    AutomaticChoice,
    Setting,
    denoise_automatically,
    estimate_noise,
    filter_face_normals,
    normal_filtering,
    replace_outlying,
)
from pymeshfair.filters.denoising.completion import DEFAULTS
from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.denoising.preparation import along_normals
from pymeshfair.filters.diffusion import taubin_fairing
from pymeshfair.filters.geometry import face_normals, mean_edge_length, mean_normals_at_vertices
from pymeshfair.filters.inspection import folded_faces
from pymeshfair.plugins.denoising import STEP_ONE, apply_coord_normal_filtering, apply_normal_robust_filtering_per_face
from tests.angles import mean_angle
from tests.meshes import Floats, Ints, Mesh, cube, icosphere, irregular_grid, noisy


@dataclass
class Surface:
    """As much of a layer as the filters read."""

    vertices: Floats
    faces: Ints
    chosen: Bools | None = None
    face_selection: Bools = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    @property
    def mean_edge(self) -> float:
        return mean_edge_length(self.vertices, self.faces)

    @property
    def face_normals(self) -> Floats:
        return face_normals(self.vertices, self.faces)

    def selected_vertices(self) -> Bools:
        assert self.chosen is not None
        return self.chosen


def apply(declared: Filter, surface: Surface, **values: Any) -> Edit:
    """The edit that the filter returns, its parameters checked and completed as the host does."""
    assert declared.function is not None
    return declared.function(cast(Layer, surface), **declared.with_defaults(values))


def filtered(mesh: Mesh, chosen: Bools | None = None, **values: Any) -> tuple[Floats, dict[str, Any]]:
    """The vertices after normal filtering, and the values that it reports."""
    edit = apply(apply_coord_normal_filtering, Surface(*mesh, chosen), **values)
    assert edit.vertices is not None
    return edit.vertices, dict(edit.values)


@pytest.fixture(scope="module")
def true() -> Mesh:
    """A cube of 386 vertices."""
    return cube(3)


@pytest.fixture(scope="module")
def rough(true: Mesh) -> Mesh:
    """The cube with noise of 0.15 of its shorter edges along the normals, which spreads no vertices along the surface."""
    vertices, faces = true
    outward = mean_normals_at_vertices(face_normals(*true), faces, len(vertices))
    return vertices + np.random.default_rng(0).normal(0.0, 0.15 / 8, (len(vertices), 1)) * outward, faces


def test_what_is_given_is_what_is_done(rough: Mesh) -> None:
    """With every parameter given the vertices are those of the technique; the values name each parameter and what it did.

    The drift is the mean displacement in mean edges; faces that look away from those around them are counted.
    """
    edit = apply(apply_coord_normal_filtering, Surface(*rough), **DEFAULTS)
    assert edit.vertices is not None
    np.testing.assert_array_equal(edit.vertices, normal_filtering(*rough))
    assert {name: edit.values[name] for name in DEFAULTS} == DEFAULTS
    moved = np.linalg.norm(edit.vertices - rough[0], axis=1).mean() / mean_edge_length(*rough)
    assert edit.values["drift"] == pytest.approx(moved, rel=1e-12)
    folded = [int(folded_faces(vertices, rough[1]).sum()) for vertices in (rough[0], edit.vertices)]
    assert [edit.values["folded_before"], edit.values["folded_after"]] == folded
    touched = {f.name for f in fields(edit) if getattr(edit, f.name) is not None and f.name not in ("new_layers", "notes")}
    assert touched == {"vertices", "values"}


def test_by_default_everything_is_automatic_and_the_report_repeats_it(rough: Mesh, true: Mesh) -> None:
    """The result is that of the automatic choice, nearer to the truth; the filter with the reported parameters does the same."""
    vertices, values = filtered(rough)
    expected, choice = denoise_automatically(*rough)
    np.testing.assert_array_equal(vertices, expected)
    assert choice.setting.parameters is not None
    assert {name: values[name] for name in vars(choice.setting.parameters)} == vars(choice.setting.parameters)
    assert values["relaxation"] == choice.setting.relaxation
    assert len(values["tried"]) > 1
    assert values["noise"] == choice.noise.deviation
    before, after = (mean_angle(face_normals(v, rough[1]), face_normals(*true)) for v in (rough[0], vertices))
    assert after < 0.2 * before
    again, _ = filtered(rough, **{name: values[name] for name in DEFAULTS})
    np.testing.assert_allclose(again, vertices, rtol=0, atol=1e-12)


def test_a_given_parameter_narrows_what_is_tried(rough: Mesh) -> None:
    """All that is tried has it, nothing at all apart; so the others are those that go best with it."""
    _, values = filtered(rough, range_kernel="lorentzian", range_sigma=0.2)
    tried = [trial["parameters"] for trial in values["tried"] if trial["parameters"] is not None]
    assert {(parameters["range_kernel"], parameters["range_sigma"]) for parameters in tried} == {("lorentzian", 0.2)}
    assert (values["range_kernel"], values["range_sigma"]) == ("lorentzian", 0.2)
    assert values["method"] in {parameters["method"] for parameters in tried}
    assert min(trial["error"] for trial in values["tried"]) < values["tried"][0]["error"]


def test_a_mesh_without_noise_is_left_alone() -> None:
    """A sheet as it was designed keeps every bit, and a note says why."""
    vertices, faces = irregular_grid()
    edit = apply(apply_coord_normal_filtering, Surface(vertices, faces))
    assert edit.vertices is not None
    assert edit.vertices.tobytes() == vertices.tobytes()
    assert len(edit.notes) == 1
    assert edit.values["drift"] == 0.0


def test_faces_that_stay_folded_are_said_and_slivers_named() -> None:
    """On a sheet of triangles of 1:20 with very strong noise faces stay folded over: a note has both numbers and why."""
    vertices, faces = irregular_grid(30, 30)
    vertices = vertices * [0.05, 1.0, 1.0]
    vertices += np.random.default_rng(1).normal(0.0, 1.0, vertices.shape)
    edit = apply(apply_coord_normal_filtering, Surface(vertices, faces), choice="fixed")
    before, after = (edit.values[f"folded_{when}"] for when in ("before", "after"))
    assert 0 < after <= before
    (note,) = edit.notes
    assert f"{after} faces are folded over, {before} were before" in note
    assert "slivers" in note


def test_faces_that_are_turned_against_their_neighbours_are_said() -> None:
    """A face turned over in a noisy sheet looks away from those around it, and its three edges are counted in a note."""
    vertices, faces = noisy(irregular_grid(12, 12), 0.1)
    within = int(np.argmin(np.linalg.norm(vertices[faces].mean(axis=1) - vertices.mean(axis=0), axis=1)))
    faces[within] = faces[within, ::-1]
    (note,) = apply(apply_coord_normal_filtering, Surface(vertices, faces), choice="fixed").notes
    assert note.endswith("; 3 edges join faces that are oriented differently: run Re-Orient all faces coherently first")


def test_where_neighbours_share_the_noise_the_border_is_named(rough: Mesh) -> None:
    """An open mesh gets a note that nothing speaks for its border; a closed one has none."""
    for (vertices, faces), named in ((irregular_grid(5, 5), True), (rough, False)):
        made = AutomaticChoice("correlated", Setting(relaxation=3), estimate_noise(vertices, faces))
        with mock.patch("pymeshfair.filters.denoising.completion.automatic_choice", return_value=made):
            notes = apply(apply_coord_normal_filtering, Surface(vertices, faces)).notes
        assert [("at the border" in note) for note in notes] == [True] * named


def test_only_selected_vertices_move(rough: Mesh) -> None:
    """With `selected` the others keep every bit."""
    chosen = rough[0][:, 2] > 0.5
    vertices, _ = filtered(rough, chosen, selected=True, **DEFAULTS)
    assert ((vertices != rough[0]).any(axis=1) == chosen).all()


def test_face_normals_alone(rough: Mesh, true: Mesh) -> None:
    """The second filter returns step one: unit normals nearer to the truth, the vertices untouched; or those of some faces."""
    settings = {name: DEFAULTS[name] for name in STEP_ONE}
    edit = apply(apply_normal_robust_filtering_per_face, Surface(*rough), **settings)
    assert edit.face_normals is not None
    assert edit.vertices is None
    np.testing.assert_array_equal(edit.face_normals, filter_face_normals(*rough))
    automatic = apply(apply_normal_robust_filtering_per_face, Surface(*rough)).face_normals
    assert automatic is not None
    np.testing.assert_allclose(np.linalg.norm(automatic, axis=1), 1.0, rtol=0, atol=1e-12)
    assert mean_angle(automatic, face_normals(*true)) < 0.5 * mean_angle(face_normals(*rough), face_normals(*true))
    some = np.arange(len(rough[1])) % 2 == 0
    part = apply(apply_normal_robust_filtering_per_face, Surface(*rough, face_selection=some), selected=True, **settings)
    assert part.face_normals is not None
    np.testing.assert_array_equal(part.face_normals[some], edit.face_normals[some])
    np.testing.assert_array_equal(part.face_normals[~some], face_normals(*rough)[~some])


def test_face_normals_of_a_clean_mesh_stay() -> None:
    """Where Normal Filtering has no round, the automatic number of passes over the normals, its total, is 0."""
    clean = icosphere(3)
    edit = apply(apply_normal_robust_filtering_per_face, Surface(*clean))
    assert (edit.values["shape"], edit.values["normal_iterations"]) == ("clean", 0)
    assert edit.face_normals is not None
    np.testing.assert_allclose(edit.face_normals, face_normals(*clean), rtol=0, atol=1e-15)


def test_with_everything_given_the_mesh_is_not_estimated(rough: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    """A recipe with explicit values does not pay for the automatic choice, and no choice is reported."""

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("the mesh was estimated")

    monkeypatch.setattr("pymeshfair.filters.denoising.completion.automatic_choice", refuse)
    assert "shape" not in filtered(rough, **DEFAULTS)[1]
    _, fixed = filtered(rough, choice="fixed")
    assert {name: fixed[name] for name in vars(FIXED)} == vars(FIXED)
    with pytest.raises(AssertionError, match="estimated"):
        filtered(rough, **{**DEFAULTS, "range_sigma": "auto"})
    first = {name: DEFAULTS[name] for name in STEP_ONE}
    assert "shape" not in apply(apply_normal_robust_filtering_per_face, Surface(*rough), **first).values


def test_a_clean_mesh_is_left_alone_where_only_the_preparation_is_set() -> None:
    """What is set before normal filtering is done, and no normal filtering is added; if nothing is done, a note says so."""
    vertices, faces = icosphere(3)
    for values in ({"outliers": "keep"}, {"rounding": "keep"}, {"relaxation_direction": "normal"}):
        edit = apply(apply_coord_normal_filtering, Surface(vertices, faces), **values)
        assert edit.vertices is not None
        np.testing.assert_array_equal(edit.vertices, vertices)
        assert edit.notes == (NOTHING_TO_REMOVE,)
    moved, reported = filtered((vertices, faces), relaxation=3)
    np.testing.assert_array_equal(moved, taubin_fairing(vertices, faces, iterations=3))
    assert reported["outer_iterations"] == 0


def test_steps_of_taubin_come_first_and_may_keep_to_the_normals(rough: Mesh) -> None:
    """Relaxation does what Taubin's filter before would do; along the normals it is its part along those of a smoothed copy."""
    vertices, faces = rough
    fair = taubin_fairing(vertices, faces, iterations=4)
    along = along_normals(vertices, fair, smooth_normals(vertices, faces))
    for direction, start in (("all", fair), ("normal", along)):
        moved, _ = filtered(rough, **{**DEFAULTS, "relaxation": 4, "relaxation_direction": direction})
        np.testing.assert_allclose(moved, normal_filtering(start, faces), rtol=0, atol=1e-12)
    slid = np.cross(along - vertices, smooth_normals(vertices, faces))
    assert np.abs(slid).max() < 1e-12


@pytest.mark.parametrize("size", [1.0, 2.0**530, 2.0**-530])
def test_outliers_are_replaced_first_and_nothing_else_where_that_is_said(rough: Mesh, size: float) -> None:
    """With 0 outer iterations and no relaxation the vertices that stand out move, and the others keep every bit, in any unit."""
    vertices, faces = rough[0].copy(), rough[1]
    vertices[40::60] *= 1.3
    moved, _ = filtered((vertices * size, faces), **{**DEFAULTS, "outliers": "replace", "outer_iterations": 0})
    moved /= size
    expected, outlying = replace_outlying(vertices, faces)
    assert outlying[40::60].any()
    np.testing.assert_array_equal(moved, expected)
    np.testing.assert_array_equal((moved != vertices).any(axis=1), outlying)


def test_progress_ends_at_1_where_nothing_is_compared() -> None:
    """`compare` has no effect with fixed values, and the time that it would take is not left open."""
    shares: list[float] = []
    values = apply_coord_normal_filtering.with_defaults({"compare": True, "choice": "fixed"})
    assert apply_coord_normal_filtering.function is not None
    apply_coord_normal_filtering.function(cast(Layer, Surface(*icosphere(2))), **values, progress=shares.append)
    assert shares[-1] == 1.0
