"""`pymeshfair list` names the filters and the recipes."""

from __future__ import annotations

import subprocess
import sys

import pytest

from pymeshfair.recipe import TASKS, load_recipe, shipped_heads, shipped_recipes
from pymeshfair.registry import all_filters, custom_filters

from .command_line import document, invoke


def test_filters_are_all_there() -> None:
    """Without a search, every filter of the registry is listed, both kinds."""
    listed = document(invoke("list", "filters", "--json").stdout)["filters"]
    assert [f["python_name"] for f in listed] == [f.python_name for f in all_filters()]
    assert {f["origin"] for f in listed} == {"MeshLab", "pymeshfair"}


def test_a_filter_is_its_name_and_lines_that_fit() -> None:
    """Its Python name has a line for itself, names and summary stand below, and no line is wider than a terminal."""
    printed = invoke("list", "filters").stdout
    lines = printed.splitlines()
    assert max(map(len, lines)) <= 100
    for known in custom_filters():
        assert known.python_name in lines
        assert known.summary in " ".join(printed.split())


def test_several_words_narrow_the_list() -> None:
    """All of them must be there, in any order, and need no quotes."""
    listed = document(invoke("list", "filters", "fairing", "hole", "--json").stdout)["filters"]
    assert "meshing_close_holes_by_fairing" in {f["python_name"] for f in listed}
    assert len(listed) < 10


def test_the_origin_is_searched_too() -> None:
    """The name of a package is a word, too."""
    listed = document(invoke("list", "filters", "meshlab", "taubin", "--json").stdout)["filters"]
    assert listed
    assert {f["origin"] for f in listed} == {"MeshLab"}


@pytest.mark.parametrize("text", ["taubin smooth", "Taubin_Smooth", "smoothing taubin"])
def test_search_takes_words_in_any_order_case_and_spelling(text: str) -> None:
    """A filter is found by words of its Python name or its MeshLab name."""
    listed = document(invoke("list", "filters", text, "meshlab", "--json").stdout)["filters"]
    assert [f["python_name"] for f in listed] == ["apply_coord_taubin_smoothing"]


def test_search_without_a_result_says_so() -> None:
    """Nothing found is no error: an empty list and a sentence on stderr."""
    done = invoke("list", "filters", "zebra")
    assert (done.exit_code, done.stdout) == (0, "")
    assert "'zebra'" in done.stderr
    assert document(invoke("list", "filters", "zebra", "--json").stdout) == {"filters": []}


def test_recipes_are_listed_without_compiled_code() -> None:
    """The heads of the recipes are read without loading a plugin, and say what the loaded recipes say."""
    program = (
        "import sys\nfrom pymeshfair.commands.app import main\nsys.argv = ['pymeshfair', 'list', 'recipes']\n"
        "try: main()\nexcept SystemExit as end: print(end.code, [m for m in ('numba', 'pymeshlab') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "0 []", done.stderr
    loaded = [load_recipe(name) for name in shipped_recipes()]
    assert [(h.name, h.info, h.steps) for h in shipped_heads()] == [(r.name, r.info, len(r.script.steps)) for r in loaded]


def test_recipes_are_named_with_their_purpose_by_task() -> None:
    """Every shipped recipe has a title, says for which scans it is, and stands with those for the same task."""
    listed = document(invoke("list", "recipes", "--json").stdout)["recipes"]
    assert sorted(r["name"] for r in listed) == list(shipped_recipes())
    assert all(r["title"] and r["for"] and r["fits"] and r["steps"] > 0 for r in listed)
    tasks = [r["task"] for r in listed]
    assert list(dict.fromkeys(tasks)) == [task for task in TASKS if task in tasks]
    assert tasks == sorted(tasks, key=TASKS.index)
    shown = invoke("list", "recipes").stdout
    plain = " ".join(shown.split())
    assert all(r["name"] in plain and r["title"] in plain and r["for"] in plain for r in listed)
    assert max(map(len, shown.splitlines())) <= 80
