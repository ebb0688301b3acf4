"""What a worker writes to stderr, and the values that it reports."""

from __future__ import annotations

import json
import os
import pickle
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Length
from pymeshfair.files.provenance import formatted
from pymeshfair.operating_system import this_system
from pymeshfair.processes.environment import thread_settings, versions, worker_environment
from pymeshfair.running.job import Job, Message, PhaseStarted, StepProgress, plain
from pymeshfair.running.supervise import Talk, mark, parse_talk
from pymeshfair.scripts.guards import Guards

from .runs import recipe_of


def test_jobs_and_events_cross_the_pipe() -> None:
    """Steps keep their values exactly: lengths in their unit, colours, choices, numbers to the last digit; events every word."""
    recipe = recipe_of(
        ("meshing_isotropic_explicit_remeshing", {"targetlen": Length(1 / 3, "percent"), "featuredeg": 0.1}),
        ("meshing_close_holes", {"maxholesize": 7, "refinehole": True, "refineholeedgelen": Length(0.1)}),
        ("apply_coord_implicit_fairing", {"detail_size": Length(2.5, "edge")}),
        ("compute_selection_by_color_per_face", {"color": (1, 2, 3, 4)}),
        ("apply_coord_explicit_smoothing", {"operator": "cotangent"}),
    )
    job = Job(recipe, Path("in.ply"), Path("out.ply"), memory_limit=10**9, guards=Guards.parse({"require": "manifold"}))
    said = [job, PhaseStarted("reading"), StepProgress(1, 0.25), Message("a b\nc", "warning")]
    assert pickle.loads(pickle.dumps(said)) == said


#: MeshLab's words on steps that did nothing, and parts of the tensor of inertia
SAY_NOTHING = (
    "Removed 0 duplicated vertices",
    "Successfully deleted 0 duplicated faces",
    "Successfully split 0 non manifold vertices faces",
    "Closed 0 holes and added 0 new faces",
    "Nothing done: no vertex selected",
    "Inertia Tensor is :",
    "| 513497155.565961  40029463.718512  1661412.806189 |",
)


@pytest.mark.parametrize(
    ("line", "talk"),
    [
        ("LOG: 2 Remeshing    [ 33% ]", Talk("Remeshing", 2, 0.33)),
        ("LOG: 2 apply_coord_taubin_smoothing applied!    [ 100% ]", Talk("apply_coord_taubin_smoothing applied!", 2, 1.0)),
        ("LOG: 2 Closed 3 holes", Talk("Closed 3 holes", 2)),
        ("LOG: 2 Removed 10 null faces", Talk("Removed 10 null faces", 2)),
        *((f"LOG: 2 {line}", Talk("", 2)) for line in SAY_NOTHING),
        ("LOG: 1 Warning: 50% of it", Talk("Warning: 50% of it", 1)),
        ("LOG: 2 x [ 400% ]", Talk("x", 2, 1.0)),
        ("Segmentation fault", Talk("Segmentation fault")),
        (mark(12).decode().strip(), Talk("", step=12)),
        ("pymeshfair-step x", Talk("pymeshfair-step x")),
    ],
)
def test_stderr_is_taken_apart(line: str, talk: Talk) -> None:
    """Progress, MeshLab's words with their level, our marks and the rest are distinguished; what says nothing is empty."""
    assert parse_talk(line) == talk


def test_plain_values() -> None:
    """What filters take and give becomes what JSON has; what is not finite becomes text; pymeshlab's objects their numbers."""
    values = {
        "a": np.float64(0.5),
        "b": [np.int32(1), True, None, "x"],
        "c": float("nan"),
        "d": (float("inf"), -np.inf),
        "e": Length(2.0),
        "f": Length(1.0, "percent"),
        "g": np.eye(2),
        "h": np.zeros((100, 3)),
        "i": pymeshlab.PercentageValue(3),
        "j": pymeshlab.Color(1, 2, 3, 4),
        5: np.bool_(True),
    }
    assert plain(values) == {
        "a": 0.5,
        "b": [1, True, None, "x"],
        "c": "nan",
        "d": ["inf", "-inf"],
        "e": 2.0,
        "f": "1.0%",
        "g": [[1.0, 0.0], [0.0, 1.0]],
        "h": "array of shape (100, 3)",
        "i": 3.0,
        "j": [1, 2, 3, 4],
        "5": True,
    }
    meshes = pymeshlab.MeshSet()
    meshes.create_cube()
    json.dumps(plain(meshes.get_geometric_measures()), allow_nan=False)
    assert plain(meshes.current_mesh().bounding_box()) == [[-0.5] * 3, [0.5] * 3]
    assert plain(object).startswith("<class")


def test_threads_and_memory_of_a_worker() -> None:
    """Filters get the threads, linear algebra one; large memory goes back at once; what the user has set stays."""
    assert worker_environment(3, {})["OMP_NUM_THREADS"] == "3"
    own = worker_environment(None, {"OMP_NUM_THREADS": "5", "OMP_WAIT_POLICY": "ACTIVE", "HOME": "/h"})
    assert (own["OMP_NUM_THREADS"], own["NUMBA_NUM_THREADS"], own["OPENBLAS_NUM_THREADS"]) == ("5", "5", "1")
    assert (own["OMP_WAIT_POLICY"], own["HOME"]) == ("ACTIVE", "/h")
    assert worker_environment(None, {})["MALLOC_TRIM_THRESHOLD_"] == str(2**25)
    assert worker_environment(None, {"MALLOC_TRIM_THRESHOLD_": "9"})["MALLOC_TRIM_THRESHOLD_"] == "9"
    assert worker_environment(None, {"PYTHONIOENCODING": "latin-1"})["PYTHONIOENCODING"] == "utf-8"
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    assert worker_environment(None, {})["NUMBA_NUM_THREADS"] == str(processors)


@pytest.mark.parametrize("given", ["2,1", " 2"])
def test_a_list_of_threads_for_nested_loops(given: str) -> None:
    """OpenMP takes a list of numbers of threads, one for each depth of loops; filters take the first."""
    assert worker_environment(None, {"OMP_NUM_THREADS": given})["NUMBA_NUM_THREADS"] == "2"


def test_memory_of_a_process() -> None:
    """The peak is at least what the interpreter and numpy take; no limit changes nothing."""
    this_system().limit_memory(None)
    peak = this_system().peak_memory()
    assert peak is None or peak > 20e6


def test_provenance_is_json_without_surprises() -> None:
    """The document is strict JSON, knows every package it names, and refuses a number that is not finite."""
    known = versions()
    assert known["pymeshlab"]
    assert known["pymeshfair"]
    assert json.loads(formatted({"versions": known, "name": "é"})) == {"versions": known, "name": "é"}
    with pytest.raises(ValueError, match="Out of range"):
        formatted({"x": float("nan")})
    assert thread_settings({"OMP_NUM_THREADS": "2", "PATH": "/"}) == {"OMP_NUM_THREADS": "2"}
