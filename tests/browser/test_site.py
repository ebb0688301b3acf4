"""The site: it is built without a warning, its search finds what people ask for, and its examples do what they say."""

from __future__ import annotations

import functools
import http.server
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pymeshfair.declaration import Filter
from pymeshfair.recipe import load_recipe, shipped_recipes

pytest.importorskip("mkdocs", reason="mkdocs is not installed: it is in the extra `docs`")
import site_pages
from first_run_scans import write_scans

ROOT = Path(__file__).parents[2]
#: what people type, and a page that must be among the first ten answers
PHRASES = {
    "remove noise keep edges": "filters/apply_coord_normal_filtering.html",
    "fill hole smooth": "recipes/fill_holes_smoothly.html",
    "MeshLab script": "writing_recipes.html",
    "outliers point cloud": "recipes/remove_outliers.html",
    "3D print": "recipes/prepare_for_print.html",
    "many scans batch": "batch.html",
    "old MeshLab version": "old_scripts.html",
    "Taubin": "filters/apply_coord_taubin_fairing.html",
    "mean curvature": "filters/compute_scalar_by_mean_curvature_per_vertex.html",
    "larger than memory": "scale.html",
}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built site; a warning, as of a link to nothing, is an error."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.mark.slow
def test_every_filter_and_every_recipe_has_a_page(site: Path) -> None:
    """And no picture is there that no page shows."""
    filters = {f"{f.python_name}.html" for f in site_pages.own_filters()}
    assert {p.name for p in (site / "filters").iterdir()} == filters
    assert {p.name for p in (site / "recipes").iterdir()} == {f"{name}.html" for name in shipped_recipes()}
    assert {p.with_suffix(".html").name for p in site_pages.PICTURES.iterdir()} <= filters


@pytest.mark.slow
@pytest.mark.parametrize("declared", site_pages.own_filters(), ids=lambda f: f.python_name)
def test_the_example_of_a_filter_runs(declared: Filter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In Python on at least one of the scans that recipes are measured on; as a script it is the same step."""
    monkeypatch.chdir(tmp_path)
    reasons = []
    for scan in write_scans(tmp_path).values():
        for name in ("scan.ply", "other.ply"):
            (tmp_path / name).write_bytes(scan.read_bytes())
        try:
            exec(site_pages.python_example(declared), {})
            break
        except Exception as error:
            reasons.append(f"{scan.stem}: {error}")
    else:
        pytest.fail("\n".join(reasons))
    (tmp_path / "step.mlx").write_text(site_pages.script_example(declared), encoding="utf-8")
    [step] = load_recipe(str(tmp_path / "step.mlx")).script.steps
    assert step.filter == declared


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """The site, served to this machine."""

    class Silent(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: Any) -> None:
            """Nothing is printed."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Silent, directory=str(site))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.mark.slow
def test_the_search_finds_what_people_type(browser: Any, address: str) -> None:
    """The page for each phrase is among the first ten answers."""
    page = browser.new_page()
    missed = []
    for phrase, wanted in PHRASES.items():
        page.goto(f"{address}/index.html?q={phrase.replace(' ', '+')}")
        page.wait_for_selector(".md-search-result__item a", timeout=20000)
        links = page.eval_on_selector_all(".md-search-result__item > a", "all => all.map(a => a.href)")
        if not any(wanted in link for link in links[:10]):
            missed.append(f"{phrase}: {links[:10]}")
    assert not missed, "\n".join(missed)
