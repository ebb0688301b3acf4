"""The spectral filter of a surface: its responses, its routes, and what it leaves alone."""

from __future__ import annotations

import math
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from pymeshfair.filters import execution as parallel
from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.spectral.spectral_filter import spectral_filter
from tests.meshes import AWKWARD, Floats, Mesh, diagonal, grid, icosphere, noisy, renumbered, rotation, torus, two_spheres

ROUTES = ("eigenvectors", "polynomial")


def wavy_sheet(waves: int, height: float = 1e-5, columns: int = 96) -> tuple[Mesh, float]:
    """A sheet of 48 x `columns` unit squares with so many waves along x, and the wavelength.

    cos(k x) with whole waves has slope 0 at the borders of the sheet, so it is a mode there, of the eigenvalue 2 - 2 cos k. The
    waves are too low to matter to the metric.
    """
    vertices, faces = grid(48, columns)
    vertices[:, 2] = height * np.cos(2 * np.pi * waves * vertices[:, 0] / columns)
    return (vertices, faces), columns / waves


def ratio_of_heights(before: Floats, after: Floats) -> float:
    """By what the heights of the sheet were multiplied, in the least-squares sense."""
    return float((before[:, 2] @ after[:, 2]) / (before[:, 2] @ before[:, 2]))


@pytest.mark.parametrize("method", ROUTES)
@pytest.mark.parametrize("waves", [2, 4])
def test_a_wave_of_the_detail_size_comes_out_with_half_its_amplitude(waves: int, method: Any) -> None:
    """A plane wave of length l = 2 pi / k is halved, up to the difference between k^2 and the mesh's 2 - 2 cos k."""
    (vertices, faces), length = wavy_sheet(waves)
    found = spectral_filter(vertices, faces, detail_size=length, method=method, tolerance=1e-8)
    assert found.route in (method, "rational")
    k = 2 * math.pi / length
    ratio = ratio_of_heights(vertices, found.vertices)
    assert ratio == pytest.approx(0.5 ** ((2 - 2 * math.cos(k)) ** 2 / k**4), abs=1e-6)
    assert ratio == pytest.approx(0.5, abs=math.log(2) * k**2 / 12)


def test_other_waves_are_multiplied_by_the_response() -> None:
    """A wave twice as long keeps 2^-(1/16) of its amplitude, one half as long 2^-16, for the default order 2."""
    for factor, expected in ((0.5, 2.0 ** -(1 / 16)), (2.0, 2.0**-16)):
        (vertices, faces), length = wavy_sheet(4)
        found = spectral_filter(vertices, faces, detail_size=length * factor, tolerance=1e-9).vertices
        assert ratio_of_heights(vertices, found) == pytest.approx(expected, abs=2e-3)


def test_enhancing_multiplies_the_band_and_keeps_the_rest() -> None:
    """In the middle of the band a wave is multiplied by nearly the gain; far from it waves keep their height."""
    (vertices, faces), length = wavy_sheet(4)

    def ratio(detail_size: float) -> float:
        options: dict[str, Any] = {"detail_size": detail_size, "largest_size": 4 * detail_size, "gain": 3.0, "tolerance": 1e-8}
        return ratio_of_heights(vertices, spectral_filter(vertices, faces, response="enhance", **options).vertices)

    # F = 1 + 2 (2^-(1/16) - 2^-16) in the middle of two octaves
    assert ratio(length / 2) == pytest.approx(1 + 2 * (2 ** -(1 / 16) - 2**-16), abs=5e-3)
    assert ratio(length / 32) == pytest.approx(1.0, abs=1e-3)
    assert ratio(length * 8) == pytest.approx(1.0, abs=1e-3)


def test_a_band_and_its_complement_add_up() -> None:
    """What the band pass gives, about the centroid, is what enhancing adds with a gain of 2."""
    vertices, faces = noisy(torus(), 0.02)
    options: dict[str, Any] = {"detail_size": 1.0, "largest_size": 3.0, "tolerance": 1e-10}
    band = spectral_filter(vertices, faces, response="band_pass", **options).vertices
    enhanced = spectral_filter(vertices, faces, response="enhance", **options).vertices
    shift = (band - (enhanced - vertices))[0]
    np.testing.assert_allclose(band - (enhanced - vertices), np.tile(shift, (len(vertices), 1)), rtol=0, atol=1e-8)


@pytest.mark.parametrize("response", ["low_pass", "band_pass", "enhance"])
@pytest.mark.parametrize("mesh", [noisy(icosphere(3), 0.02), noisy(grid(16, 20), 0.1)], ids=["sphere", "sheet"])
def test_both_routes_give_the_same(mesh: Mesh, response: Any) -> None:
    """For the same smooth response they agree within the sum of the errors that they report, root mean square."""
    size = 0.3 * diagonal(mesh[0])
    found = [spectral_filter(*mesh, response=response, detail_size=size, method=m) for m in ("eigenvectors", "polynomial")]
    difference = np.linalg.norm(found[0].vertices - found[1].vertices, axis=1)
    assert np.sqrt((difference**2).mean()) <= 2 * (found[0].error + found[1].error) + 1e-9 * diagonal(mesh[0])
    assert found[0].modes > 0
    assert found[1].degree > 0


def test_a_number_of_modes_is_a_brick_wall() -> None:
    """Three modes of a sphere, those of l = 1, give back the sphere: the constant one is kept and not counted.

    On the exact sphere the coordinates are these three modes, up to the discretisation.
    """
    vertices, faces = icosphere(3)
    found = spectral_filter(vertices, faces, modes=3)
    assert (found.route, found.modes, found.error) == ("eigenvectors", 3, 0.0)
    assert found.detail_size == pytest.approx(2 * math.pi / math.sqrt(2), rel=0.02)
    np.testing.assert_allclose(found.vertices, vertices, rtol=0, atol=2e-3)
    np.testing.assert_allclose(spectral_filter(vertices, faces, modes=len(vertices)).vertices, vertices, rtol=0, atol=1e-12)


def test_a_number_of_modes_ends_a_band() -> None:
    """The band holds the modes that as many lowest ones have, less those longer than its longest wave; `enhance` adds it."""
    vertices, faces = noisy(icosphere(3), 0.02)
    low = spectral_filter(vertices, faces, modes=40)
    longer = spectral_filter(vertices, faces, modes=8)
    size = longer.detail_size * 0.999
    band = spectral_filter(vertices, faces, modes=40, response="band_pass", largest_size=size)
    more = spectral_filter(vertices, faces, modes=40, response="enhance", gain=3.0, largest_size=size)
    about = low.vertices - longer.vertices
    assert (band.route, band.modes, band.detail_size) == ("eigenvectors", 40, low.detail_size)
    np.testing.assert_allclose(band.vertices - band.vertices.mean(axis=0), about - about.mean(axis=0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(more.vertices, vertices + 2.0 * about, rtol=0, atol=1e-9)


def test_every_component_keeps_its_centroid_and_none_counts() -> None:
    """However many components there are, as many waves are kept: three rebuild a large sphere, twenty small ones stay apart."""
    large, small = icosphere(3), icosphere(0, 0.01)
    centres = np.column_stack([2.0 + 0.1 * np.arange(20), np.zeros(20), np.zeros(20)])
    vertices = np.vstack([large[0], *(small[0] + centre for centre in centres)])
    faces = np.vstack([large[1], *(small[1] + np.int32(len(large[0]) + len(small[0]) * k) for k in range(20))])
    for modes in (3, 8):
        found = spectral_filter(vertices, faces, modes=modes)
        assert (found.route, found.modes) == ("eigenvectors", modes)
        assert math.isfinite(found.detail_size)
        np.testing.assert_allclose(found.vertices[: len(large[0])], large[0], rtol=0, atol=2e-3)
        np.testing.assert_allclose(found.vertices[len(large[0]) :], np.repeat(centres, len(small[0]), axis=0), rtol=0, atol=1e-9)


def test_more_modes_are_nearer() -> None:
    """The error of the rebuilt shape falls with the number of modes, and all of them but one leave next to nothing."""
    vertices, faces = noisy(torus(), 0.02)
    errors = [np.linalg.norm(spectral_filter(vertices, faces, modes=k).vertices - vertices) for k in (5, 20, 100, 200)]
    assert (np.diff(errors) < 0).all()


def test_the_wavelength_of_a_number_of_modes_without_eigenvectors_is_weyls() -> None:
    """sqrt(pi area / modes), within a few percent of that of the mode on a sphere."""
    vertices, faces = icosphere(4)
    by_law = spectral_filter(vertices, faces, modes=99, method="polynomial")
    assert by_law.route in ("polynomial", "rational")
    assert by_law.detail_size == pytest.approx(2 * math.pi / math.sqrt(9 * 10), rel=0.07)


def test_components_are_filtered_one_by_one() -> None:
    """Two components come out as each alone does, and the centroids stay."""
    vertices, faces = two_spheres()
    vertices = noisy((vertices, faces), 0.02)[0]
    half = len(vertices) // 2
    both = spectral_filter(vertices, faces, detail_size=0.8, tolerance=1e-10).vertices
    alone = spectral_filter(vertices[:half], faces[: len(faces) // 2], detail_size=0.8, tolerance=1e-10).vertices
    np.testing.assert_allclose(both[:half], alone, rtol=0, atol=1e-8)


def test_motion_scale_and_numbering_make_no_difference() -> None:
    """The filter of a moved, scaled or renumbered mesh is the moved, scaled or renumbered result."""
    mesh = noisy(torus(), 0.05)
    vertices, faces = mesh
    plain = spectral_filter(vertices, faces, detail_size=1.5, tolerance=1e-10).vertices
    turn = rotation()
    moved = spectral_filter(3.0 * vertices @ turn.T + 7.0, faces, detail_size=4.5, tolerance=1e-10).vertices
    np.testing.assert_allclose(moved, 3.0 * plain @ turn.T + 7.0, rtol=0, atol=1e-8)
    others, renamed, order = renumbered(mesh)
    found = spectral_filter(others, renamed, detail_size=1.5, tolerance=1e-10).vertices
    np.testing.assert_allclose(found, plain[order], rtol=0, atol=1e-8)


def test_far_from_the_origin_nothing_is_lost() -> None:
    """A geo-referenced mesh comes out as the same mesh at the origin, up to the rounding of its coordinates."""
    vertices, faces = noisy(icosphere(3), 0.02)
    far = np.array([5e5, 5.5e6, 300.0])
    moved = spectral_filter(vertices + far, faces, detail_size=0.5).vertices
    plain = spectral_filter((vertices + far) - far, faces, detail_size=0.5).vertices
    np.testing.assert_allclose(moved - far, plain, rtol=0, atol=1e-8)


def test_only_movable_vertices_move() -> None:
    """The others keep every bit; those that move go where they would have gone."""
    vertices, faces = noisy(icosphere(3), 0.02)
    some = vertices[:, 2] > 0.2
    part = spectral_filter(vertices, faces, detail_size=0.5, movable=some).vertices
    everything = spectral_filter(vertices, faces, detail_size=0.5).vertices
    assert part[~some].tobytes() == vertices[~some].tobytes()
    assert part[some].tobytes() == everything[some].tobytes()
    nothing = spectral_filter(vertices, faces, detail_size=0.5, movable=np.zeros(len(vertices), dtype=np.bool_))
    assert (nothing.route, nothing.vertices.tobytes()) == ("none", vertices.tobytes())


def test_a_flat_sheet_stays_flat() -> None:
    """Nothing leaves the plane, to the bit."""
    found = spectral_filter(*grid(), detail_size=4.0).vertices
    assert (found[:, 2] == 0.0).all()


@pytest.mark.parametrize("options", [{"response": "low_pass"}, {"response": "enhance"}, {"response": "band_pass"}, {"modes": 3}])
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_stay_finite(name: str, options: dict[str, Any]) -> None:
    """Nothing becomes NaN or leaves the mesh by more than the gain allows, and vertices that no face uses keep every bit."""
    vertices, faces = AWKWARD[name]()
    size = 0.2 * 2 * diagonal(vertices / 2) if len(vertices) else 1.0
    found = spectral_filter(vertices, faces, **{**({} if "modes" in options else {"detail_size": size or 1.0}), **options})
    assert np.isfinite(found.vertices).all()
    assert found.error >= 0.0
    if len(vertices):
        assert np.linalg.norm(found.vertices / 2 - vertices / 2, axis=1).max() <= diagonal(vertices / 2)
    unused = ~topology.referenced_vertices(faces, len(vertices))
    assert found.vertices[unused].tobytes() == vertices[unused].tobytes()


def test_the_input_is_not_written_to_and_the_result_repeats() -> None:
    """Two calls give the same bits, from arrays that cannot be written to."""
    vertices, faces = noisy(icosphere(2), 0.02)
    vertices.flags.writeable = faces.flags.writeable = False
    for options in ({"detail_size": 0.7}, {"modes": 20}):
        first, second = (spectral_filter(vertices, faces, **options) for _ in range(2))
        assert first.vertices.tobytes() == second.vertices.tobytes()
        assert first.vertices is not vertices


@pytest.mark.parametrize("options", [{"detail_size": 0.4}, {"modes": 30}], ids=["without modes", "modes"])
def test_the_number_of_threads_makes_no_difference(options: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The result on one thread is, bit by bit, that on all of them."""
    mesh = noisy(icosphere(4), 0.01)
    alone = spectral_filter(*mesh, **options).vertices
    monkeypatch.setattr(parallel, "SERIAL_BELOW", 0)
    assert spectral_filter(*mesh, **options).vertices.tobytes() == alone.tobytes()


def test_progress_is_told_and_may_stop() -> None:
    """The share rises to 1, and an exception of the receiver comes out."""
    told: list[float] = []
    spectral_filter(*icosphere(2), detail_size=0.7, progress=told.append)
    assert told[-1] == 1.0
    assert all(0.0 <= share <= 1.0 for share in told)

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    for options in ({"detail_size": 0.7}, {"modes": 20}):
        with pytest.raises(KeyboardInterrupt):
            spectral_filter(*icosphere(2), progress=stop, **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "give either detail_size, a wavelength, or modes"),
        ({"detail_size": 1.0, "modes": 3}, "give either detail_size"),
        ({"detail_size": -1.0}, r"detail_size is -1\.0: it must be finite and above 0"),
        ({"detail_size": math.nan}, "detail_size is nan: it must be finite"),
        ({"modes": 0}, "modes is 0: it must be a whole number of at least 1"),
        ({"modes": 2.5}, r"modes is 2\.5"),
        ({"detail_size": 1.0, "response": "high_pass"}, "response 'high_pass' is not one of 'low_pass'"),
        ({"detail_size": 1.0, "method": "fast"}, "method 'fast' is not one of 'auto'"),
        ({"detail_size": 1.0, "response": "enhance", "largest_size": 0.5}, "largest_size 0.5 is not above detail_size 1.0"),
        ({"detail_size": 1.0, "tolerance": 0.0}, r"tolerance is 0\.0: it must be finite and above 0"),
        ({"detail_size": 1.0, "order": 0}, "order is 0: it must be a whole number from 1 to 8"),
        ({"detail_size": 1.0, "operator": "uniform"}, "operator 'uniform' is not one of"),
        ({"detail_size": 1.0, "movable": [True]}, "movable must be a boolean array of 42 values"),
    ],
)
def test_parameters_are_checked(options: dict[str, Any], message: str) -> None:
    """What is out of range is an error that names the parameter, the value and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        spectral_filter(*icosphere(1), **options)


@pytest.mark.parametrize("method", ["eigenvectors", "polynomial"])
def test_a_band_that_the_modes_leave_empty_is_told_in_mesh_units(method: Any) -> None:
    """The largest size in the error is the one that was given, on a mesh of any size."""
    vertices, faces = icosphere(2)
    with pytest.raises(FilterInputError, match=r"largest_size 1\.0 is not above detail_size \d\d\d\.\d+: no wave is in between"):
        spectral_filter(100.0 * vertices, faces, response="enhance", modes=20, largest_size=1.0, method=method)


def test_a_point_cloud_is_refused() -> None:
    """A surface is needed; the message says what to do."""
    with pytest.raises(FilterInputError, match="no triangles: spectral filters need a surface; triangulate"):
        spectral_filter(icosphere(1)[0], np.empty((0, 3), dtype=np.int32), detail_size=1.0)


def test_modes_that_memory_does_not_hold_are_refused() -> None:
    """The message gives the amount and the way out; nothing is computed."""
    with pytest.raises(FilterInputError, match="GB: take the method 'polynomial'"):
        spectral_filter(*icosphere(5), detail_size=0.01, method="eigenvectors")


def test_auto_does_without_modes_that_memory_does_not_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same call takes the smooth response at Weyl's wavelength."""
    monkeypatch.setattr(import_module("pymeshfair.filters.spectral.spectral_filter"), "LARGEST_BASIS", 1000)
    found = spectral_filter(*icosphere(3), modes=50)
    assert found.route in ("polynomial", "rational")
    assert found.detail_size == pytest.approx(2 * math.pi / math.sqrt(7 * 8), rel=0.07)
