"""`MeshSet` as a drop-in for pymeshlab's that knows the filters of plugins, too."""

from __future__ import annotations

import inspect
import locale
import logging
import pickle
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import (
    Arity,
    Edit,
    FilterClass,
    Float,
    Layer,
    Length,
    Mesh,
    MeshElement,
    NewLayer,
    Percentage,
    mesh_filter,
)
from pymeshfair.errors import ConvergenceError, FilterInputError, Place, StepFailedError
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.meshlab.base import (
    FilterFailedError,
    FilterParameterError,
    ScriptStepFailedError,
    UnknownFilterError,
    UnknownLayerError,
)
from pymeshfair.meshlab.builtin_filters import checked
from pymeshfair.meshset import MeshSet
from pymeshfair.registry import custom_filters, find_filter
from pymeshfair.scripts import Step
from tests.host.snapshots import differences, everything, give_back, same, sample
from tests.meshes import icosphere, torus


@mesh_filter(name="Shift", classes=FilterClass.SMOOTHING, requires=MeshElement.FACENUMBER)
def apply_coord_shift(
    layer: Layer,
    *,
    distance: Annotated[float, Percentage(label="Distance", help="How far. Larger is farther.", default="1%")],
    times: Annotated[float, Float(label="Times", help="How often.", minimum=0)] = 1.0,
    progress: Progress = ignore_progress,
) -> Edit:
    """Moves the mesh along x."""
    for done in (0.5, 1.0):
        progress(done)
    moved = layer.vertices + np.array([distance * times, 0.0, 0.0])
    return Edit(vertices=moved, values={"distance": distance}, notes=("It was moved.",))


@mesh_filter(name="Measure Against", classes=FilterClass.MEASURE, arity=Arity.FIXED)
def get_distance_to(layer: Layer, *, reference: Annotated[int, Mesh(label="Reference", help="The other layer.")] = 0) -> Edit:
    """Tells how far the first vertices of two layers are apart."""
    return Edit(values={"distance": float(np.linalg.norm(layer.vertices[0] - layer.other(reference).vertices[0]))})


@mesh_filter(name="Make Point", classes=FilterClass.MESH_CREATION, arity=Arity.NONE)
def create_point(layer: Layer) -> Edit:
    """Makes a layer of one point."""
    assert not len(layer.vertices)
    return Edit(new_layers=(NewLayer(label="point", vertices=np.zeros((1, 3))),))


def shift(**values: Any) -> Step:
    """A step of the filter above."""
    return Step(apply_coord_shift, apply_coord_shift.check(values))


def ball() -> MeshSet:
    """A mesh set with one sphere."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)), "ball")
    return meshes


# ------------------------------------------------------------------------------------------------------------- plugins' filters


def test_every_filter_of_a_plugin_is_a_method_with_a_signature_and_a_docstring() -> None:
    """The method's keyword-only parameters, defaults and help are those of the declaration."""
    for known in custom_filters():
        method = getattr(MeshSet, known.python_name)
        signature = inspect.signature(method)
        assert [*signature.parameters] == ["self", *(p.name for p in known.parameters)]
        assert all(p.kind is p.KEYWORD_ONLY for p in [*signature.parameters.values()][1:])
        assert method.__name__ == known.python_name
        text = inspect.getdoc(method)
        assert text is not None
        assert " ".join(text.split()).startswith(known.summary)  # a long line is wrapped
        assert all(f"    {p.name}: " in text for p in known.parameters)
        assert all(f"[{key}]" in text for key in known.references)
        assert repr(known.name) in text


def test_a_method_gives_what_the_filter_reports_or_none() -> None:
    """Like pymeshlab's own methods, one of ours gives a dictionary, or None when there is nothing to report."""
    meshes = ball()
    report = meshes.get_surface_measures()
    assert report is not None
    assert report["vertices"] == 162
    assert meshes.apply_coord_taubin_fairing(iterations=1) is None
    assert meshes.apply_filter("apply_coord_taubin_fairing", iterations=1) == {}


@pytest.mark.parametrize(
    ("length", "distance"),
    [
        ("10%", 0.1 * 12**0.5),
        ("0.25", 0.25),
        ("0.5edge", 0.5),
        (Length(2.0, "edge"), 2.0),
        (pymeshlab.PercentageValue(10), 0.1 * 12**0.5),
        (pymeshlab.PureValue(0.25), 0.25),
        (None, 0.01 * 12**0.5),
    ],
)
def test_lengths_can_be_said_in_every_way(length: Any, distance: float) -> None:
    """Percent is of the diagonal, "edge" of the mean edge, and PercentageValue(0.1), kept as a C float, is still 0.1 %."""
    meshes = MeshSet()
    corners = np.array([[x, y, z] for x in (0, 2) for y in (0, 2) for z in (0, 2)], dtype=float)
    meshes.add_mesh(pymeshlab.Mesh(corners, np.array([[0, 1, 3], [4, 5, 7]])))  # halves of two sides of a cube
    expected = distance * ((2.0 + 2.0 + 8**0.5) / 3 if "edge" in str(length) else 1.0)
    given = checked(apply_coord_shift, {} if length is None else {"distance": length})
    assert meshes.apply_step(Step(apply_coord_shift, given))["distance"] == pytest.approx(expected, rel=1e-12)


def test_pymeshlabs_lengths_reach_filters_of_plugins() -> None:
    """PercentageValue and PureValue are taken where text is, without the noise of single precision."""
    meshes = ball()
    meshes.apply_coord_implicit_fairing(detail_size=pymeshlab.PercentageValue(0.1))
    meshes.apply_coord_implicit_fairing(detail_size=pymeshlab.PureValue(0.1))
    assert [step.values["detail_size"] for step in meshes._script.steps] == [Length(0.1, "percent"), Length(0.1)]


def test_a_bare_number_is_no_length() -> None:
    """Neither kind of filter takes a bare number for a length; the message says what to write."""
    meshes = ball()
    for name, parameter in (("apply_coord_implicit_fairing", "detail_size"), ("meshing_merge_close_vertices", "threshold")):
        said = rf"^{name}: parameter '{parameter}' is a length, and 0.3 has no unit: write '0.3edge' for .* or '0.3' in quotes"
        with pytest.raises(FilterParameterError, match=said):
            meshes.apply_filter(name, **{parameter: 0.3})


def test_preconditions_are_checked() -> None:
    """A filter that needs faces refuses a cloud by name, and any filter a mesh set without a mesh."""
    meshes = MeshSet()
    with pytest.raises(FilterFailedError, match="apply_coord_shift needs a mesh"):
        meshes.apply_step(shift())
    with pytest.raises(FilterFailedError, match="meshing_merge_close_vertices needs a mesh"):
        meshes.meshing_merge_close_vertices()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(3)), "dots")
    with pytest.raises(FilterFailedError, match="apply_coord_shift cannot be applied: 'dots' has no faces"):
        meshes.apply_step(shift())


def test_a_filter_that_needs_no_mesh_makes_one() -> None:
    """Creation works on an empty mesh set."""
    meshes = MeshSet()
    meshes.apply_step(Step(create_point))
    assert meshes.current_mesh().label() == "point"


@pytest.mark.parametrize(
    ("raised", "message"),
    [
        (FilterInputError("bad mesh"), "fail: bad mesh"),
        (ConvergenceError("residual 3"), "fail: residual 3"),
        (ZeroDivisionError("oops"), "fail: ZeroDivisionError: oops"),
    ],
)
def test_errors_of_filters_are_pymeshlabs_and_ours(raised: Exception, message: str) -> None:
    """What a filter raises comes out as FilterFailedError, which is a PyMeshLabException, with its name and its cause."""

    @mesh_filter(name="Fail", classes=FilterClass.OTHER)
    def fail(layer: Layer) -> Edit:
        """Fails."""
        raise raised

    meshes = ball()
    before = everything(meshes)
    with pytest.raises(pymeshlab.PyMeshLabException) as caught:
        meshes.apply_step(Step(fail))
    assert isinstance(caught.value, FilterFailedError)
    assert str(caught.value) == message
    assert caught.value.__cause__ is raised
    assert differences(before, everything(meshes)) == []


def test_progress_is_told_and_can_stop_a_filter() -> None:
    """on_progress hears every share of the work; what it raises stops the filter and comes out as it is."""
    meshes = ball()
    heard: list[float] = []
    meshes.on_progress = heard.append
    meshes.apply_step(shift())
    assert heard == [0.5, 1.0]

    def stop(done: float) -> None:
        raise InterruptedError

    meshes.on_progress = stop
    before = everything(meshes)
    with pytest.raises(InterruptedError):
        meshes.apply_step(shift())
    assert differences(before, everything(meshes)) == []


def test_notes_go_to_the_listener_or_to_the_log(caplog: pytest.LogCaptureFixture) -> None:
    """What a filter wants read reaches on_note, or else the logger, as information: a program that went well logs no warning."""
    meshes = ball()
    with caplog.at_level(logging.INFO, "pymeshfair"):
        meshes.apply_step(shift())
    assert [record.message for record in caplog.records] == ["It was moved."]
    heard: list[str] = []
    meshes.on_note = heard.append
    meshes.apply_step(shift())
    assert heard == ["It was moved."]
    assert len(caplog.records) == 1


# -------------------------------------------------------------------------------------------------------------- MeshLab's filters


def test_built_in_filters_give_what_plain_pymeshlab_gives() -> None:
    """A chain of MeshLab's filters leaves the same mesh to the bit, and gives the same report, as in pymeshlab itself."""
    results = []
    for kind in (pymeshlab.MeshSet, MeshSet):
        meshes = kind()
        meshes.load_new_mesh(sample("bone.ply"))
        meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=1000)
        meshes.apply_coord_taubin_smoothing(lambda_=0.3, stepsmoothnum=5)
        meshes.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(50))
        report = meshes.get_geometric_measures()
        results.append((everything(meshes), report["surface_area"], meshes.filter_parameter_values("generate_alpha_shape")))
    assert differences(results[0][0], results[1][0]) == []
    assert results[0][1:] == results[1][1:]


def test_text_lengths_work_for_meshlabs_filters() -> None:
    """Text and PercentageValue mean the same; percent is of the diagonal also where MeshLab's own percentages are not."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("bone.ply"))
    diagonal = meshes.current_mesh().bounding_box().diagonal()
    values = meshes.filter_parameter_values
    in_percent = values("generate_alpha_shape", alpha=pymeshlab.PercentageValue(3))["alpha"]
    assert values("generate_alpha_shape", alpha="3%")["alpha"] == in_percent
    assert values("generate_alpha_shape", alpha="0.2")["alpha"] == pytest.approx(0.2)
    assert values("generate_alpha_shape", alpha="250%")["alpha"] == pytest.approx(2.5 * diagonal)
    edge = meshes._bench.current().mean_edge
    assert values("generate_alpha_shape", alpha="2edge")["alpha"] == pytest.approx(2 * edge)
    # MeshLab's 100 % of this one is a hundredth of the diagonal
    merge = meshes.filter_parameter_values
    assert merge("meshing_merge_close_vertices", threshold="1%")["threshold"] == pytest.approx(0.01 * diagonal)
    own = merge("meshing_merge_close_vertices", threshold=pymeshlab.PercentageValue(1))["threshold"]
    assert own == pytest.approx(1e-4 * diagonal)


def test_unknown_names_get_a_suggestion() -> None:
    """A misspelt filter, method or parameter of either kind names the one that was meant."""
    meshes = ball()
    cases: list[tuple[str, dict[str, Any], str]] = [
        ("aply_coord_taubin_fairing", {}, "apply_coord_taubin_fairing"),
        ("meshing_merge_clos_vertices", {}, "meshing_merge_close_vertices"),
        ("apply_coord_taubin_fairing", {"iteration": 1}, "iterations"),
        ("apply_coord_taubin_smoothing", {"lamda": 1.0}, "lambda_"),
    ]
    for name, values, meant in cases:
        with pytest.raises(UnknownFilterError, match=f"did you mean '{meant}'") as caught:
            meshes.apply_filter(name, **values)
        assert isinstance(caught.value, pymeshlab.PyMeshLabException)
        assert caught.value.suggestion == meant
    with pytest.raises(AttributeError, match="did you mean 'apply_coord_taubin_fairing'"):
        meshes.apply_coord_taubin_fairng()  # type: ignore[attr-defined]
    with pytest.raises(UnknownFilterError, match="did you mean"):
        meshes.filter_parameter_values("apply_coord_taubin_fairng")


def test_a_gui_name_serves_as_well() -> None:
    """apply_filter takes the name that a filter has in menus and scripts."""
    meshes = ball()
    meshes.apply_filter("Taubin Fairing", iterations=1)
    meshes.apply_filter("Taubin Smooth", stepsmoothnum=1)
    assert [step.filter.python_name for step in meshes._script.steps] == [
        "apply_coord_taubin_fairing",
        "apply_coord_taubin_smoothing",
    ]


def test_layers_that_are_not_there_are_named_instead_of_crashing() -> None:
    """An id without a layer, which crashes MeshLab's filters, is refused for both kinds and for the current mesh."""
    meshes = ball()
    with pytest.raises(UnknownLayerError, match=r"get_hausdorff_distance: .*'targetmesh': there is no layer 7 .*0 'ball'"):
        meshes.get_hausdorff_distance(targetmesh=7)
    with pytest.raises(UnknownLayerError, match="get_distance_to: parameter 'reference': there is no layer 7"):
        meshes.apply_step(Step(get_distance_to, {"reference": 7}))
    with pytest.raises(UnknownLayerError, match="there is no layer -1"):
        meshes.set_current_mesh(-1)
    assert meshes.current_mesh_id() == 0


def test_ids_in_scripts_do_not_count_helper_layers() -> None:
    """A layer made after vertices were moved has an id beyond the one that scripts say; both directions agree."""
    meshes = ball()
    meshes.apply_step(shift())
    meshes.apply_step(shift())
    meshes.add_mesh(pymeshlab.Mesh(*torus()), "ring")
    meshes.apply_step(shift())
    meshes.generate_convex_hull()
    ids = [m.id() for m in meshes]
    assert ids == [0, 3, 5]
    meshes.apply_filter("get_hausdorff_distance", sampledmesh=3, targetmesh=5)
    recorded = meshes._script.steps[-1].values
    assert (recorded["sampledmesh"], recorded["targetmesh"]) == (1, 2)
    again = meshes.apply_step(Step(get_distance_to, {"reference": 1}))["distance"]
    assert again == np.linalg.norm(meshes.mesh(5).vertex_matrix()[0] - meshes.mesh(3).vertex_matrix()[0])
    assert [meshes._bench.with_helpers(meshes._bench.without_helpers(i)) for i in ids] == ids
    meshes.clear()
    meshes.create_cube()
    assert meshes._bench.without_helpers(meshes.current_mesh_id()) == meshes.current_mesh_id() == 0


def test_parameter_values_of_both_kinds() -> None:
    """filter_parameter_values gives lengths in mesh units, for filters of plugins as for MeshLab's."""
    meshes = ball()
    values = meshes.filter_parameter_values("apply_coord_implicit_fairing", detail_size="10%", iterations=2)
    assert values["detail_size"] == pytest.approx(0.1 * meshes._bench.current().diagonal)
    assert values["iterations"] == 2
    assert [*values] == [p.name for p in find_filter("apply_coord_implicit_fairing").parameters]


# ------------------------------------------------------------------------------------------------------------------- the process


def test_helpers_are_silent_and_filters_of_plugins_speak_when_verbose(capfd: pytest.CaptureFixture[str]) -> None:
    """A verbose mesh set tells of our filter and its parameters, and nothing of the filters that carry its result."""
    meshes = MeshSet(verbose=True)
    meshes.create_cube()
    capfd.readouterr()
    meshes.apply_step(shift(distance="0.5"))
    meshes.apply_step(give_back(Edit(vertex_scalars=np.arange(8.0))))
    out, err = capfd.readouterr()
    assert "Applying filter apply_coord_shift with the following parameters:\n{'distance': 0.5, 'times': 1.0}" in out
    assert "morph" not in out + err
    assert "function" not in out + err
    meshes.set_verbosity(False)
    meshes.apply_step(shift())
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("verbose", [False, True])
def test_after_a_failure_the_next_mesh_set_can_load(verbose: bool) -> None:
    """MeshLab writes to the log of the mesh set whose filter failed last; with plain pymeshlab the second load crashes."""
    program = f"""
        import gc, sys
        import pymeshlab, pymeshfair
        meshes = pymeshfair.MeshSet(verbose={verbose})
        meshes.create_cube()
        for condition in ("nonsense(", "more nonsense"):
            try:
                meshes.compute_selection_by_condition_per_vertex(condselect=condition)
            except pymeshlab.PyMeshLabException:
                pass
            else:
                sys.exit("the filter did not fail")
        del meshes
        gc.collect()
        for _ in range(5):
            pymeshfair.MeshSet().load_new_mesh({sample("bone.ply")!r})
        print("survived", file=sys.stderr)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr.splitlines()[-1:]) == (0, ["survived"])


def test_errors_can_cross_a_process() -> None:
    """The errors keep type, message and attributes when they are pickled."""
    place = Place.of_step(2, 3, "Shift", file=Path("a.mlx"), line=7)
    step = ScriptStepFailedError(place, "it broke")
    unknown = UnknownFilterError("no such filter", suggestion="other")
    for error in (
        step,
        StepFailedError(place, "no"),
        unknown,
        FilterFailedError("x"),
        FilterParameterError("y"),
        UnknownLayerError("z"),
    ):
        copy = pickle.loads(pickle.dumps(error))
        assert (type(copy), str(copy), vars(copy)) == (type(error), str(error), vars(error))
    assert str(step) == "step 2 of 3, 'Shift' (a.mlx:7): it broke"


def test_the_handle_of_a_mesh_stays_good() -> None:
    """A mesh fetched before a filter of ours shows the new state after it, as with MeshLab's own."""
    meshes = ball()
    handle = meshes.current_mesh()
    before = handle.vertex_matrix()
    meshes.apply_step(shift(distance="1"))
    assert same(handle.vertex_matrix(), before + np.array([1.0, 0.0, 0.0]))


def test_a_3mf_file_leaves_the_locale_of_the_program(tmp_path: Path) -> None:
    """MeshLab's library sets the locale "C" for the whole process, after which Python reads texts as ASCII."""
    kept = locale.setlocale(locale.LC_ALL)
    try:
        locale.setlocale(locale.LC_ALL, "C.UTF-8")
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(*icosphere(1)))
        meshes.save_current_mesh(str(tmp_path / "ball.3mf"))
        meshes.load_new_mesh(str(tmp_path / "ball.3mf"))
        assert locale.setlocale(locale.LC_ALL) == "C.UTF-8"
    finally:
        locale.setlocale(locale.LC_ALL, kept)


@pytest.mark.parametrize("number", [300_000, np.float32(300_000), np.int64(300_000)])
def test_numbers_beyond_bounds_of_the_mesh_may_be_of_numpy(number: Any) -> None:
    """A call of pymeshlab would translate by five diagonals."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])))
    meshes.compute_matrix_from_translation(axisx=number)
    assert meshes.current_mesh().vertex_matrix()[:, 0].tolist() == [300_001, 300_000, 300_000]


@pytest.mark.parametrize("values", [{"axisx": 1e39}, {"axisx": 300_000, "axisy": float("nan")}])
def test_numbers_that_no_script_can_have_are_refused_beyond_bounds(values: dict[str, Any]) -> None:
    """The script that takes the place of the call would lack them, and do something else."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])))
    with pytest.raises(FilterParameterError, match="takes a number"):
        meshes.compute_matrix_from_translation(**values)
