"""The report in a browser: opened from a file, with the network off."""

from __future__ import annotations

import json
import re
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from tests.browser.pixels import canvas_pixels, halves, share_changed, soon
from tests.commands.command_line import document, invoke
from tests.meshes import icosphere

#: what an attacker may call a scan
NAME = "<img src=x onerror=alert(1)>&amp;.ply"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The report of an egg and the same with a dent, out of tolerance, and the document of the same comparison."""
    folder = tmp_path_factory.mktemp("report")
    vertices, faces = icosphere(4)
    egg = vertices * [1.0, 1.4, 1.0]
    dented = egg - 0.15 * vertices * np.exp(-8.0 * ((vertices - [0.0, 0.3, 0.95]) ** 2).sum(axis=1))[:, None]
    for name, shape in ((NAME, egg), ("after.ply", dented)):
        trimesh.Trimesh(shape, faces, process=False).export(folder / name)
    made = folder / "report.html"
    more = ("--no-self-intersections", "--tolerance", "0.05", "--limits", "-0.2,0.2", "--section", "y=0.3", "--section", "y=9")
    done = invoke("compare", folder / NAME, folder / "after.ply", "--report", made, "--json", *more)
    assert done.exit_code == 1, done.stderr
    return made, document(done.stdout)


@pytest.fixture
def opened(page: Any, report: tuple[Path, dict[str, Any]], errors: list[str]) -> Any:
    """The report on a page, once its meshes are there; the test fails if it asks for anything but itself."""
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(report[0].as_uri())
    page.wait_for_selector("[data-ready]", timeout=30_000)
    yield page
    assert [url for url in asked if not url.startswith("data:") and url != report[0].as_uri()] == []
    assert errors == []


def test_it_shows_both_meshes(opened: Any) -> None:
    """Each view of the canvas has pixels that are not ground, and the dent makes them different."""
    before, after = halves(canvas_pixels(opened))
    for view in (before, after):
        assert 0.1 < share_changed(view, np.broadcast_to(view[0, 0], view.shape)) < 0.9
    assert share_changed(before, after) > 0.01


@pytest.mark.slow
def test_the_switch_changes_what_is_seen(opened: Any) -> None:
    """Every colouring changes pixels; distances colour the view after alone; one view alone is wider."""
    plain = canvas_pixels(opened)
    opened.check("input[value=distance]")
    moved = canvas_pixels(opened)
    assert share_changed(halves(plain)[0], halves(moved)[0]) == 0.0
    assert share_changed(halves(plain)[1], halves(moved)[1]) > 0.05
    assert soon(opened, lambda: opened.locator("[data-color-bar]").is_visible())
    seen = [plain, moved]
    for style in ("curvature", "reflection"):
        opened.check(f"input[value={style}]")
        seen.append(canvas_pixels(opened))
        assert all(share_changed(seen[-1], other) > 0.02 for other in seen[:-1])
    opened.check("input[name=views][value='1']")
    assert soon(opened, lambda: opened.locator("[data-view-name]").all_inner_texts()[0] == "after")
    assert share_changed(canvas_pixels(opened), seen[-1]) > 0.02


@pytest.mark.slow
def test_both_views_turn_together(opened: Any) -> None:
    """Dragging in one view, and the keys, change the pixels of both in the same way."""
    at_first = canvas_pixels(opened)
    box = opened.locator("canvas").bounding_box()
    x, y = box["x"] + box["width"] / 4, box["y"] + box["height"] / 2
    opened.mouse.move(x, y)
    opened.mouse.down()
    opened.mouse.move(x + 30, y + 170, steps=4)
    opened.mouse.up()
    dragged = canvas_pixels(opened)
    for old, new in zip(halves(at_first), halves(dragged), strict=True):
        assert share_changed(old, new) > 0.02
    before, after = halves(dragged)
    # The egg is seen from above: as high as wide in both views.
    for view in (before, after):
        rows, columns = np.nonzero(np.abs(view - view[0, 0]).max(axis=2) > 24)
        assert np.ptp(rows) < 1.2 * np.ptp(columns)
    opened.locator("canvas").focus()
    opened.keyboard.press("0")
    assert share_changed(canvas_pixels(opened), at_first) < 0.002
    assert soon(opened, lambda: opened.locator("[data-status]").inner_text().startswith("azimuth 0 degrees"))


def test_it_says_failed_and_lists_the_areas(opened: Any, report: tuple[Path, dict[str, Any]]) -> None:
    """The verdict is the first thing, and the table of areas has the place, amount, size and area of the document."""
    assert opened.locator(".verdict.bad strong").inner_text().startswith("Failed: ")
    rows = opened.locator("table", has_text="Areas out of tolerance").locator("tbody tr")
    areas = report[1]["comparison"]["out_of_tolerance"]
    assert rows.count() == len(areas) == 2
    for k, area in enumerate(areas):
        place = ", ".join(f"{c:.6g}" for c in area["place"])
        told = [place, f"{area['amount']:+.4g}", f"{area['size']:.4g}", f"{area['area']:.4g}"]
        assert rows.nth(k).locator("td").all_inner_texts() == told


def test_it_shows_six_sides_and_sections(opened: Any) -> None:
    """Every side has a picture that is loaded, the plane that cuts the meshes an outline of both; limits are those given."""
    for side in ("front", "back", "left", "right", "top", "bottom"):
        picture = opened.locator(f"img[alt^='The mesh after, {side}:']")
        assert picture.evaluate("image => image.naturalWidth") == 300
    drawn = opened.locator("section[aria-labelledby=sections-title] svg")
    assert drawn.count() == 1
    for line in ("before", "after"):
        assert len(drawn.locator(f"path.{line}").get_attribute("d")) > 100
    opened.check("input[value=distance]")
    assert soon(opened, lambda: opened.locator("[data-low]").inner_text() == "-0.2")


def test_a_button_goes_to_the_largest_distance(opened: Any, report: tuple[Path, dict[str, Any]]) -> None:
    """The place of the Hausdorff distance, which is on BEFORE, comes to the middle of the left view, marked by a ring."""
    first, found = report[1]["comparison"]["out_of_tolerance"][0], report[1]["comparison"]["hausdorff"]
    assert (first["mesh"], first["amount"]) == ("before", found["mesh_units"])
    opened.locator("[data-approach]").first.click()
    canvas_pixels(opened)
    box, ring = opened.locator("canvas").bounding_box(), opened.locator("[data-marker]").first.bounding_box()
    assert ring["x"] + ring["width"] / 2 == pytest.approx(box["x"] + 0.25 * box["width"], abs=3)
    assert ring["y"] + ring["height"] / 2 == pytest.approx(box["y"] + box["height"] / 2, abs=3)


def test_its_numbers_are_those_of_the_document(opened: Any, report: tuple[Path, dict[str, Any]]) -> None:
    """The data in the page are the document that the command printed, with names for paths, and the table shows them."""
    expected = {**report[1], "files": {"before": NAME, "after": "after.ply"}}
    assert json.loads(opened.locator("#numbers").text_content()) == expected
    cells = opened.locator("table", has_text="Hausdorff distance").first.locator("tr").last.locator("td").all_inner_texts()
    found = expected["comparison"]["hausdorff"]
    assert cells == [f"{found[unit]:.4g}" for unit in ("mesh_units", "mean_edges", "percent_of_diagonal")]


@pytest.mark.slow
def test_the_keys_zoom_within_limits(opened: Any) -> None:
    """However often + is pressed, a view shows 1/2000 of the scene at least."""
    opened.locator("canvas").focus()
    for _ in range(50):
        opened.keyboard.press("+")
    assert soon(opened, lambda: opened.locator("[data-status]").inner_text().endswith(" 2000.00 times"))


def test_the_pointer_tells_the_distance(opened: Any) -> None:
    """Over the dent of the mesh after the number is near its depth, over the ground there is none."""
    opened.check("input[value=distance]")
    canvas_pixels(opened)
    box = opened.locator("canvas").bounding_box()
    opened.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.4 * box["height"])
    assert soon(opened, lambda: opened.locator("[data-value]").inner_text().startswith("here -0.1"))
    opened.mouse.move(box["x"] + 0.52 * box["width"], box["y"] + 0.04 * box["height"])
    assert soon(opened, lambda: opened.locator("[data-value]").inner_text() == "")


def test_a_name_stays_a_name(opened: Any) -> None:
    """Markup in the name of a file is shown as text: it makes no element and runs nothing."""
    assert NAME in opened.locator("h1").inner_text()
    assert opened.locator("img[src=x]").count() == 0


def test_it_serves_who_does_not_see(opened: Any) -> None:
    """Every picture, chart and canvas has words, every switch a label, and tables their headers."""
    assert all(words.strip() for words in opened.locator("img").evaluate_all("all => all.map(x => x.alt)"))
    assert opened.locator("canvas").get_attribute("aria-label")
    assert opened.locator("svg[role=img] > title").count() == opened.locator("svg").count() > 3
    assert opened.locator("input").evaluate_all("all => all.every(x => x.labels.length === 1)")
    assert opened.locator("table").evaluate_all("all => all.every(x => x.caption && x.querySelector('th[scope=col]'))")


def test_pictures_have_one_width_and_the_colour_bar_a_row(opened: Any) -> None:
    """Before, after and the six sides are beside each other, three in a row; the bar with their colours is below them all."""
    widths = opened.eval_on_selector_all(".pictures figure", "all => all.map(figure => figure.offsetWidth)")
    assert len(set(widths[:-1])) == 1
    assert widths[-1] > 2.9 * widths[0]


def test_it_fits_a_telephone(opened: Any) -> None:
    """At 360 pixels nothing has to be pushed sideways."""
    opened.set_viewport_size({"width": 360, "height": 740})
    assert soon(opened, lambda: opened.evaluate("document.documentElement.scrollWidth") <= 360)


def pages_of(pdf: bytes) -> int:
    """How many pages it has; its objects may be in compressed streams."""
    packed = re.findall(rb"/ObjStm.*?stream\r?\n(.*?)endstream", pdf, re.DOTALL)
    parts = [pdf, *(zlib.decompressobj().decompress(data) for data in packed)]
    return sum(len(re.findall(rb"/Type\s*/Page\b", part)) for part in parts)


def test_it_is_dark_in_the_dark_and_printed_on_few_pages(dark: Any, report: tuple[Path, dict[str, Any]]) -> None:
    """The ground is dark where dark colours are asked for, but never in print, which has four pages at most."""
    dark.goto(report[0].as_uri())
    dark.wait_for_selector("[data-ready]", timeout=30_000)
    ground = "getComputedStyle(document.body).backgroundColor"
    assert dark.evaluate(ground) == "rgb(20, 23, 28)"
    chromium = dark.context.browser.browser_type.name == "chromium"
    # Playwright gives Firefox as many centimetres as it is given inches.
    paper = ("210mm", "297mm") if chromium else ("21in", "29.7in")
    assert 1 <= pages_of(dark.pdf(width=paper[0], height=paper[1], print_background=True)) <= 4
    if chromium:  # of Firefox no other medium can be asked for
        dark.emulate_media(media="print")
        assert dark.evaluate(ground) == "rgb(255, 255, 255)"
        assert not dark.locator("form.switches").is_visible()
