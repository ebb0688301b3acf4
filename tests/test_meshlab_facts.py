"""The table of MeshLab's filters against the pymeshlab that is installed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pymeshlab
import pytest
from meshlab_survey import InstalledParameter, Survey, SurveyError, differences_from_table, survey_installed

from pymeshfair.declaration import Enum, FilterClass, Float, Int, Length, Mesh, MeshElement, Percentage, Shot
from pymeshfair.errors import ParameterError
from pymeshfair.meshlab import facts
from pymeshfair.meshlab.facts import differences_from_installed, meshlab_filters, python_name, table_version

BY_NAME = {f.python_name: f for f in meshlab_filters()}

same_version = pytest.mark.skipif(
    version("pymeshlab") != table_version(), reason=f"the table is of pymeshlab {table_version()}; doctor reports the differences"
)


@pytest.fixture(scope="module")
def installed() -> Survey:
    """What the installed pymeshlab says about its filters."""
    return survey_installed()


@pytest.mark.slow
@same_version
def test_the_table_is_that_of_the_installed_version(installed: Survey) -> None:
    """All 281 filters have the parameters, kinds, defaults, choices and bounds that the installed pymeshlab tells."""
    assert len(installed.filters) == 281
    assert sum(map(len, installed.filters.values())) == sum(len(f.parameters) for f in meshlab_filters())
    assert differences_from_table(installed) == []


@same_version
def test_names_of_filters_and_parameters_are_compared_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The installed filters have the names of the table; a filter too many, one too few and another parameter are named."""
    assert differences_from_installed() == []
    first, second, *others = meshlab_filters()
    changed = (replace(first, parameters=first.parameters[1:]), replace(second, python_name="create_teapot"), *others)
    monkeypatch.setattr(facts, "meshlab_filters", lambda: changed)
    assert differences_from_installed() == [
        f"filter {second.python_name!r} is not in the table",
        "filter 'create_teapot' is not installed",
        f"filter {first.python_name!r} has parameters that the table lacks: {first.parameters[0].name}",
    ]


def compare_with_values_on_a_cube() -> None:
    """Hold the table's defaults against pymeshlab's own values on a unit cube; to be called in a fresh process."""
    meshes = pymeshlab.MeshSet()
    meshes.create_cube()
    compared = 0
    for known in meshlab_filters():
        try:
            used = meshes.filter_parameter_values(known.python_name)
        except pymeshlab.MissingComponentException:  # a cube has no scalars of faces
            continue
        assert set(used) == {p.name for p in known.parameters}
        for parameter in known.parameters:
            if parameter.default is None:
                continue
            expected, value = parameter.default, used[parameter.name]
            if isinstance(parameter, Percentage):
                # a C float has 7 digits, the table gives parts of the diagonal with 5
                assert value == pytest.approx(expected.resolve(diagonal=3**0.5, mean_edge=lambda: 0.0), rel=1e-5)
            elif isinstance(parameter, Float):
                assert value == pytest.approx(expected, rel=6e-8, abs=0.0)  # half a unit in the last place of a C float
            elif isinstance(parameter, Enum):
                assert parameter.choices[value] == expected
            elif hasattr(value, "alpha"):
                assert (value.red(), value.green(), value.blue(), value.alpha()) == expected
            elif hasattr(value, "tolist"):
                assert value.tolist() == json.loads(json.dumps(expected))
            else:
                assert value == expected
                assert type(value) is type(expected)
            compared += 1
    assert compared > 800  # of 953; the others depend on the mesh


@same_version
def test_every_value_that_meshlab_would_use_on_a_cube_is_the_tables() -> None:
    """Independently of the survey: on a unit cube pymeshlab's own values are the table's defaults, wherever it has one.

    In a process of its own: some filters take the values of their last use as defaults.
    """
    program = f"from {__name__} import compare_with_values_on_a_cube; compare_with_values_on_a_cube()"
    root = Path(__file__).parents[1]
    environment = {**os.environ, "PYTHONPATH": str(root / "tools")}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


@same_version
@pytest.mark.parametrize(
    "name",
    [
        "apply_coord_taubin_smoothing",
        "meshing_isotropic_explicit_remeshing",
        "compute_selection_by_angle_with_direction_per_face",
    ],
)
def test_names_in_scripts_are_those_that_pymeshlab_saves(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A script saved by pymeshlab calls filter and parameters, and their types, what the table calls them, in its order."""
    meshes = pymeshlab.MeshSet()
    meshes.create_sphere()
    meshes.clear_filter_script()
    meshes.apply_filter(name)
    meshes.save_filter_script(str(tmp_path / "saved.mlx"))
    saved = ET.parse(tmp_path / "saved.mlx").getroot().find("filter")
    assert saved is not None
    assert saved.get("name") == BY_NAME[name].name
    written = [(p.get("name"), p.get("type")) for p in saved]
    assert written == [(p.xml_name, p.xml_type) for p in BY_NAME[name].parameters]


def test_names_are_unique_and_follow_pymeshlabs_rule() -> None:
    """Python names and GUI names are unique together, and each parameter's Python name follows from its name in scripts."""
    names = [name for f in meshlab_filters() for name in (f.python_name, f.name)]
    assert len(set(names)) == len(names)
    for known in meshlab_filters():
        assert known.is_builtin
        assert known.name == known.name.strip()
        assert [p.name for p in known.parameters] == [python_name(p.xml_name) for p in known.parameters]
    assert python_name("lambda") == "lambda_"
    assert python_name("Max number of refinement steps") == "max_number_of_refinement_steps"
    assert python_name("Pre-alignment") == "pre_alignment"


def test_defaults_that_depend_on_the_mesh_are_left_to_it() -> None:
    """None stands for what MeshLab computes itself: another layer, a number of triangles, whether something is selected."""
    defaults = {
        ("apply_coord_taubin_smoothing", "selected"): None,
        ("apply_coord_taubin_smoothing", "mu"): -0.53,
        ("meshing_decimation_quadric_edge_collapse", "targetfacenum"): None,
        ("meshing_decimation_quadric_edge_collapse", "qualitythr"): 0.3,
        ("get_hausdorff_distance", "sampledmesh"): None,
        ("meshing_isotropic_explicit_remeshing", "targetlen"): Length(1.0, "percent"),
        ("apply_coord_depth_smoothing", "delta"): Length(1.0),
        ("generate_surface_reconstruction_screened_poisson", "threads"): None,
        ("generate_alpha_shape", "filtering"): "Alpha Complex",
    }
    for (name, parameter_name), default in defaults.items():
        assert BY_NAME[name].parameter(parameter_name).default == default
    for known in meshlab_filters():
        for parameter in known.parameters:
            if isinstance(parameter, Mesh | Shot):
                assert parameter.default is None


def test_defaults_lie_within_their_own_bounds() -> None:
    """Every default of the table passes its own parameter's check, unchanged."""
    for known in meshlab_filters():
        values = {p.name: p.default for p in known.parameters if p.default is not None}
        assert known.check(values) == values


def test_counts_have_bounds_that_meshlab_lacks() -> None:
    """A negative or absurd number of iterations, on which MeshLab does nothing or hangs, is refused; seeds are free."""
    steps = BY_NAME["apply_coord_taubin_smoothing"].parameter("stepsmoothnum")
    for value in (-5, 2_000_000_000):
        with pytest.raises(ParameterError, match="from 0 to 100000"):
            steps.check(value)
    with pytest.raises(ParameterError, match="at least 1"):
        BY_NAME["compute_selection_point_cloud_outliers"].parameter("knearest").check(0)
    seed = BY_NAME["apply_coord_random_displacement"].parameter("randomseed")
    assert isinstance(seed, Int)
    assert seed.check(-1) == -1


def test_bounds_of_sliders_are_kept_only_where_they_hold_on_every_mesh() -> None:
    """An angle is from 0 to 180 on any mesh; an edge length, whose slider ends at half the diagonal, has no bounds here."""
    angle = BY_NAME["compute_selection_by_angle_with_direction_per_face"].parameter("anglelimit")
    length = BY_NAME["compute_selection_by_edge_length"].parameter("threshold")
    assert isinstance(angle, Float)
    assert isinstance(length, Float)
    assert (angle.minimum, angle.maximum) == (0.0, 180.0)
    assert (length.minimum, length.maximum) == (None, None)


def test_menus_and_masks_have_meshlabs_meaning() -> None:
    """Taubin Smooth is in the smoothing menu, needs triangles and changes coordinates and normals."""
    known = BY_NAME["apply_coord_taubin_smoothing"]
    assert known.classes == FilterClass.SMOOTHING
    assert known.requires == MeshElement.FACENUMBER
    assert known.changes == MeshElement.VERTCOORD | MeshElement.VERTNORMAL | MeshElement.FACENORMAL


def _with(parameters: Sequence[InstalledParameter], **changes: Any) -> tuple[InstalledParameter, ...]:
    first = parameters[0]
    values = {"name": first.name, "kind": first.kind, "default": first.default, "bounds": first.bounds, "choices": first.choices}
    return (InstalledParameter(**{**values, **changes}), *parameters[1:])


def test_another_version_of_meshlab_is_described_by_its_differences(installed: Survey) -> None:
    """Against an altered program the comparison names each kind of difference, from the version to the bounds."""
    filters = dict(installed.filters)
    del filters["create_cube"]
    filters["create_teapot"] = ()
    filters["apply_coord_taubin_smoothing"] = _with(filters["apply_coord_taubin_smoothing"], name="lamda")
    filters["apply_coord_unsharp_mask"] = _with(filters["apply_coord_unsharp_mask"], default=0.25)
    filters["generate_alpha_wrap"] = _with(filters["generate_alpha_wrap"], default=0.5)
    filters["create_sphere"] = _with(filters["create_sphere"], kind="int")
    filters["create_fractal_terrain"] = _with(filters["create_fractal_terrain"], default=9)
    filters["compute_normal_per_vertex"] = _with(filters["compute_normal_per_vertex"], choices=("A",))
    filters["create_fractal_terrain"] = (
        *filters["create_fractal_terrain"][:2],
        *_with(filters["create_fractal_terrain"][2:], bounds=(0.0, 7.0)),
    )
    told = "\n".join(differences_from_table(Survey("2031.1", filters)))
    for sentence in (
        f"pymeshlab 2031.1 is installed; the table of its filters is of {table_version()}",
        "filter 'create_teapot' is not in the table",
        "filter 'create_cube' is not installed",
        "filter 'apply_coord_taubin_smoothing': has the parameters lamda, mu",
        "filter 'apply_coord_unsharp_mask': parameter 'weight' has the default 0.25; in the table 0.3",
        "filter 'generate_alpha_wrap': parameter 'alpha' has the default 0.5; in the table '2.0%'",
        "filter 'create_sphere': parameter 'radius' has the kind 'int'; in the table it is Float",
        "filter 'compute_normal_per_vertex': parameter 'weightmode' has the choices A; in the table Simple Average",
        "has the bounds (0.0, 7.0); in the table",
    ):
        assert sentence in told


def test_the_survey_needs_no_setting_of_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """What MeshLab prints does not get among what the survey prints, however Python's streams are buffered."""
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)
    assert len(survey_installed().filters) == 281


def test_a_program_that_cannot_be_asked_is_an_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """When pymeshlab does not even import, the survey says so with the last line that it printed."""
    (tmp_path / "pymeshlab").mkdir()
    (tmp_path / "pymeshlab" / "__init__.py").write_text("raise ImportError('libGL.so.1: cannot open shared object file')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(SurveyError, match=r"libGL\.so\.1: cannot open"):
        survey_installed()


def test_the_table_is_loaded_late_and_fast() -> None:
    """Importing the registry reads no table; reading it takes under 30 ms of processor time (best of five fresh processes)."""
    code = (
        "import pymeshfair.registry, pymeshfair.meshlab.facts as m, time; assert m.table.cache_info().misses == 0;"
        "t = time.process_time(); m.meshlab_filters(); print(time.process_time() - t)"
    )
    times = [
        float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout) for _ in range(5)
    ]
    assert min(times) < 0.030
    assert facts.meshlab_filters() is facts.meshlab_filters()
