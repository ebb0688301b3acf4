"""The page to tune on in a browser, served by the command itself."""

from __future__ import annotations

import http.client
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
import trimesh
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from pymeshfair.registry import find_filter
from pymeshfair.scripts.script import Script, Step
from pymeshfair.scripts.write import write_script
from pymeshfair.tuning.server import redirecting_file
from tests.browser.conftest import note_errors
from tests.browser.pixels import canvas_pixels, halves, share_changed, soon
from tests.commands.command_line import COMMAND, document, run_process
from tests.meshes import icosphere

#: milliseconds that a worker may take to import, read and run on a busy machine
PATIENCE = 30_000


@dataclass(frozen=True)
class Served:
    """A running server: its address, the folder that it was started in, and its temporary folder."""

    address: str
    folder: Path
    temporary: Path
    process: subprocess.Popen[str]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """The server of a noisy egg; once it has been interrupted nothing of it is left."""
    folder, temporary = tmp_path_factory.mktemp("tune"), tmp_path_factory.mktemp("temporary")
    vertices, faces = icosphere(4)
    noise = np.random.default_rng(0).normal(scale=0.01, size=vertices.shape)
    trimesh.Trimesh(vertices * [1.0, 1.4, 1.0] + noise, faces, process=False).export(folder / "scan.ply")
    step = Step(find_filter("apply_coord_explicit_smoothing"))
    write_script(Script((step,), "Explicit smoothing"), folder / "explicit.mlx")
    command = [*COMMAND, "tune", "scan.ply", "--recipe", "explicit.mlx", "--no-browser", "--json"]
    environment = {**os.environ, "TMPDIR": str(temporary)}
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        printed = ""
        while not printed.endswith("}\n"):
            line = process.stdout.readline()
            assert line, "the server ended"
            printed += line
        yield Served(document(printed)["address"], folder, temporary, process)
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
    assert not list(temporary.iterdir())


@pytest.mark.slow
def test_it_ends_in_order_when_it_is_asked_to(served: Served, tmp_path: Path) -> None:
    """SIGTERM ends the server and its workers, and leaves nothing in the temporary folder."""
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    command = [*COMMAND, "tune", str(served.folder / "scan.ply"), "--no-browser"]
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("http://127.0.0.1:")
        process.terminate()
        assert process.wait(20) == 143
    assert not list(tmp_path.iterdir())


@pytest.fixture
def tuning(browser: Any, served: Served, errors: list[str]) -> Iterator[Any]:
    """The page, once the first result is there."""
    context = browser.new_context(viewport={"width": 1300, "height": 900})
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    note_errors(page, errors)
    page.goto(served.address)
    page.wait_for_selector("body[data-measured='1'], #problem:not([hidden])")
    assert not page.locator("#problem").inner_text()
    yield page
    context.close()
    assert errors == []


def test_the_file_that_the_browser_is_given_leads_to_the_page(browser: Any, served: Served, tmp_path: Path) -> None:
    """The browser follows it by itself, so that no command line has the token."""
    page = browser.new_page()
    page.goto(redirecting_file(served.address, tmp_path).as_uri())
    page.wait_for_url(served.address, timeout=PATIENCE)
    page.wait_for_selector("body[data-shown='1']", timeout=PATIENCE)
    page.close()


def change(page: Any, parameter: str, value: str) -> None:
    """Move the slider of a parameter as a hand does."""
    slider = page.locator(f"[data-parameter={parameter}] input[type=range]")
    slider.evaluate("(s, v) => { s.max = Math.max(s.max, v); s.value = v; s.dispatchEvent(new Event('input')); }", value)


def size(page: Any) -> str:
    """The mean distance between scan and result, without its sign."""
    text: str = page.locator("#numbers tr", has_text="mean without sign").locator("td").first.inner_text()
    return text


def test_a_slider_changes_the_result_alone(tuning: Any) -> None:
    """After a slider was moved the right mesh and the numbers are others, the scan on the left is the same."""
    before, mean = canvas_pixels(tuning), size(tuning)
    change(tuning, "iterations", "60")
    tuning.wait_for_selector("body[data-measured='2']")
    after = canvas_pixels(tuning)
    assert share_changed(halves(before)[0], halves(after)[0]) == 0.0
    assert share_changed(halves(before)[1], halves(after)[1]) > 0.05
    assert float(size(tuning)) > 1.5 * float(mean)


def test_warnings_on_the_change_of_shape_are_shown(tuning: Any) -> None:
    """What a run would say of a result that shrank too much stands under the numbers, and goes with the next result."""
    warning = tuning.locator("#numbers p", has_text="Warning: the shape's dimensions changed")
    change(tuning, "iterations", "400")
    tuning.wait_for_selector("body[data-measured='2']")
    assert warning.count() == 1
    change(tuning, "iterations", "1")
    tuning.wait_for_selector("body[data-measured='3']")
    assert warning.count() == 0


def test_a_change_cancels_the_run_before(tuning: Any) -> None:
    """A run of many seconds is killed by the next change, whose result is shown."""
    change(tuning, "iterations", "100000")
    tuning.wait_for_selector("body[data-begun='2']")
    assert not tuning.locator("#stop").is_disabled()
    change(tuning, "iterations", "3")
    tuning.wait_for_selector("body[data-measured='3']")
    assert tuning.locator("body").get_attribute("data-cancelled") == "1"
    assert "done in" in tuning.locator("#state").inner_text()


def type_wrong_iterations(tuning: Any, text: str) -> None:
    """Types a text into the field of the iterations, and waits until the page marks it."""
    field = tuning.locator("[data-parameter=iterations] input[type=number]")
    field.press("Control+a")
    field.press_sequentially(text)
    tuning.wait_for_selector("[data-parameter=iterations].wrong")


def test_a_wrong_value_is_shown_where_it_is(tuning: Any) -> None:
    """A number below its bound is not run; its control is marked, and the message says what is allowed."""
    type_wrong_iterations(tuning, "-5")
    assert "a whole number from 0 to 100000" in tuning.locator("#problem").inner_text()


def test_a_text_that_is_no_number_is_not_run(tuning: Any) -> None:
    """A field says so although the browser does not tell the page the text, and does not take the recipe's value in its place."""
    type_wrong_iterations(tuning, "1e")
    assert "takes a whole number from 0 to 100000, got 'no number'" in tuning.locator("#problem").inner_text()
    tuning.reload()
    tuning.wait_for_selector("body[data-measured='1']")


def test_numbers_need_no_webgl(browser: Any, served: Served) -> None:
    """A browser without it says so in place of the view; recipes run, and results can be kept."""
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(served.address)
    page.wait_for_selector("body[data-measured='1']")
    assert page.locator(".stage").inner_text().startswith("this browser draws no 3D (WebGL2)")
    assert "mean without sign" in page.locator("#numbers").inner_text()
    page.click("#keep")
    assert "root mean square distance" in page.locator("#kept li").inner_text()
    assert page.locator("#problem").is_hidden()
    page.close()


@pytest.mark.slow
def test_two_settings_beside_each_other(tuning: Any) -> None:
    """A result that was kept stays on the left while the right one changes."""
    tuning.click("#keep")
    kept = canvas_pixels(tuning)
    assert share_changed(*halves(kept)) < 0.01
    change(tuning, "iterations", "80")
    tuning.wait_for_selector("body[data-measured='2']")
    found = canvas_pixels(tuning)
    assert share_changed(halves(kept)[0], halves(found)[0]) == 0.0
    assert share_changed(*halves(found)) > 0.05


def test_the_mesh_comes_before_its_numbers(tuning: Any) -> None:
    """After a change the old result is greyed; then the new mesh is there with the old numbers greyed; then both are new."""
    tuning.evaluate(
        """() => {
          window.seen = [];
          new MutationObserver(() => {
            const look = (part) => Number(getComputedStyle(document.querySelector(part)).opacity);
            const { shown, measured } = document.body.dataset;
            const said = [shown, measured, look("canvas"), look("#numbers")].join(" ");
            if (window.seen.at(-1) !== said) window.seen.push(said);
          }).observe(document.body, { attributes: true, subtree: true });
        }"""
    )
    change(tuning, "iterations", "30")
    tuning.wait_for_selector("body[data-measured='2']")
    assert soon(tuning, lambda: tuning.evaluate("getComputedStyle(document.querySelector('#numbers')).opacity") == "1")
    seen = tuning.evaluate("window.seen")
    states = [state for k, state in enumerate(seen) if state not in seen[:k]]
    in_between = {"1 1 1 0.4"}  # the picture is lit a moment before or after its number is counted
    assert [state for state in states if state not in in_between] == ["1 1 0.4 0.4", "2 1 1 0.4", "2 2 1 1"]


def test_a_stopped_filter_costs_no_worker(tuning: Any, served: Served) -> None:
    """A filter that tells its progress stops by itself: the same process goes on."""
    before = workers(served)
    change(tuning, "iterations", "100000")
    tuning.wait_for_selector("body[data-begun='2']")
    tuning.wait_for_timeout(1000)
    change(tuning, "iterations", "3")
    tuning.wait_for_selector("body[data-measured='3']")
    assert tuning.locator("body").get_attribute("data-cancelled") == "1"
    assert before == workers(served)


def workers(served: Served) -> set[str]:
    """The numbers of the processes that work for the server."""
    listed = subprocess.run(["ps", "-o", "pid=", "--ppid", str(served.process.pid)], capture_output=True, text=True, check=True)
    return set(listed.stdout.split())


@pytest.mark.slow
def test_kept_results_and_the_way_back(tuning: Any) -> None:
    """A kept result is listed with its settings and its distance, shown on the left again, and its settings are set again."""
    change(tuning, "iterations", "25")
    tuning.wait_for_selector("body[data-measured='2']")
    tuning.click("#keep")
    entry = tuning.locator("#kept li").first
    assert "iterations 25" in entry.inner_text()
    assert "root mean square distance" in entry.inner_text()
    distance = size(tuning)
    change(tuning, "iterations", "60")
    tuning.wait_for_selector("body[data-measured='3']")
    tuning.check("input[name=views][value='0 1']")
    entry.get_by_text("Show left").click()
    assert soon(tuning, lambda: tuning.locator("[data-view-name]").first.inner_text() == "kept 1")
    entry.get_by_text("Back to it").click()
    tuning.wait_for_selector("body[data-measured='4']")
    assert tuning.locator("[data-parameter=iterations] input[type=number]").input_value() == "25"
    assert size(tuning) == distance


def test_a_kept_result_has_its_own_settings_and_numbers(tuning: Any) -> None:
    """Kept before its numbers are there a result has no distance; kept during the next run it has the settings that made it."""
    tuning.evaluate(
        """() => new MutationObserver((_, observer) => {
          if (document.body.dataset.shown === "2") { observer.disconnect(); document.querySelector("#keep").click(); }
        }).observe(document.body, { attributes: true })"""
    )
    change(tuning, "iterations", "25")
    tuning.wait_for_selector("body[data-measured='2']")
    change(tuning, "iterations", "100000")
    tuning.wait_for_selector("body[data-begun='3']")
    tuning.click("#keep")
    early, late = tuning.locator("#kept li").all_inner_texts()
    change(tuning, "iterations", "3")
    tuning.wait_for_selector("body[data-measured='4']")
    assert early.startswith("kept 1: iterations 25 ")
    assert late.startswith("kept 2: iterations 25; root mean square distance")


def test_the_colour_bar_is_that_of_the_newest_result(tuning: Any) -> None:
    """Its ends follow each result; a kept result on the left is drawn while the distances of the next are awaited."""
    tuning.check("input[name=style][value=distance]")
    tuning.click("#keep")
    shown = "['low', 'high'].map((end) => document.querySelector(`[data-${end}]`).textContent)"
    newest = "['low', 'high'].map((end) => shortNumber(state.result.colorings.distance[end]))"
    for number, iterations in ((2, "60"), (3, "200")):
        change(tuning, "iterations", iterations)
        tuning.wait_for_selector(f"body[data-measured='{number}']")
        assert soon(tuning, lambda: tuning.evaluate(shown) == tuning.evaluate(newest))


def test_a_kept_result_names_the_steps_that_were_left_out(tuning: Any) -> None:
    """The list says which steps of the recipe did not run."""
    tuning.select_option("#recipe", "clean_range_map")
    tuning.wait_for_selector("body[data-measured='2']")
    step = tuning.locator("label.step").first
    step.locator("input").uncheck()
    tuning.wait_for_selector("body[data-measured='3']")
    tuning.click("#keep")
    assert tuning.locator("#kept li").first.inner_text().startswith(f"kept 1: without {step.inner_text().strip()};")


@pytest.mark.slow
def test_settings_survive_a_reload(tuning: Any) -> None:
    """Another recipe, and a value that was changed in it, are there again when the page is loaded again."""
    tuning.select_option("#recipe", "smooth_implicit")
    tuning.wait_for_selector("body[data-measured='2']")
    tuning.locator("[data-parameter=detail_size] [data-auto]").uncheck()
    change(tuning, "detail_size", "3.5")
    tuning.wait_for_selector("body[data-measured='3']")
    value = tuning.locator("[data-parameter=detail_size] input[type=number]").input_value()
    assert float(value) == pytest.approx(3.5, abs=0.1)  # the slider has steps
    tuning.reload()
    tuning.wait_for_selector("body[data-measured='1']")
    assert tuning.locator("#recipe").input_value() == "smooth_implicit"
    assert tuning.locator("[data-parameter=detail_size] input[type=number]").input_value() == value


@pytest.mark.slow
def test_auto_is_chosen_and_its_errors_are_a_curve(tuning: Any) -> None:
    """With "auto" the slider has no say, the page runs, and the errors of what was tried stand over the slider."""
    tuning.select_option("#recipe", "smooth_implicit")
    tuning.wait_for_selector("body[data-measured='2']")
    row = tuning.locator("[data-parameter=detail_size]")
    assert row.locator("[data-auto]").is_checked()
    assert not tuning.locator("#problem").inner_text()
    assert row.locator("input[type=range]").is_disabled()
    assert row.locator("svg.curve path").get_attribute("d").count("L") > 1
    assert "did not see, least at" in row.locator("svg.curve title").text_content()


@pytest.mark.slow
def test_an_emptied_field_shows_what_runs(tuning: Any) -> None:
    """Where the recipe says "auto" an emptied field says so and ticks the box, and elsewhere the recipe's number is taken."""
    tuning.select_option("#recipe", "smooth_implicit")
    tuning.wait_for_selector("body[data-measured='2']")
    for parameter, shown, value in (("detail_size", "auto", "auto"), ("iterations", "as in the recipe", None)):
        row = tuning.locator(f"[data-parameter={parameter}]")
        field, first = row.locator("input[type=number]"), value or row.get_attribute("data-text")
        if value == "auto":
            row.locator("[data-auto]").uncheck()
        field.press("Control+a")
        field.press_sequentially("9")
        assert row.get_attribute("data-text").startswith("9")
        field.press("Backspace")
        assert field.get_attribute("placeholder") == shown
        assert row.get_attribute("data-text") == first
        field.blur()
        assert value is None or row.locator("[data-auto]").is_checked()


@pytest.mark.slow
def test_a_second_tab_takes_over(browser: Any, tuning: Any, served: Served) -> None:
    """The tab that was opened last is served, and the one before says so, names no other cause, and says so again if used."""
    second = browser.new_page()
    second.goto(served.address)
    second.wait_for_selector("body[data-measured='1']", timeout=PATIENCE)
    assert "Another page was opened for this scan" in tuning.locator("#problem").inner_text()
    assert soon(tuning, lambda: tuning.locator("#state").inner_text() == "another page has taken over")
    tuning.evaluate("complain('')")
    tuning.click("#again")
    assert soon(tuning, lambda: "Another page was opened for this scan" in tuning.locator("#problem").inner_text())
    second.close()


@pytest.mark.slow
def test_the_saved_recipe_gives_the_bytes_of_the_page(tuning: Any, served: Served) -> None:
    """The output of the page and that of the command with the recipe that the page saved are the same file."""
    change(tuning, "iterations", "7")
    tuning.wait_for_selector("body[data-measured='2']")
    tuning.fill("#recipe-name", "mine.mlx")
    tuning.fill("#note", "seven is enough")
    tuning.click("#save")
    tuning.locator("#state", has_text="saved: ").wait_for()
    tuning.fill("#output-name", "page.ply")
    tuning.click("#finish")
    tuning.locator("#state", has_text="written: ").wait_for()
    folder = served.folder
    assert "seven is enough" in (folder / "mine.mlx").read_text("utf-8")
    assert (folder / "page.ply.provenance.json").is_file()
    done = run_process("run", folder / "mine.mlx", folder / "scan.ply", "-o", folder / "command.ply")
    assert done.returncode == 0, done.stderr
    assert (folder / "page.ply").read_bytes() == (folder / "command.ply").read_bytes()
    tuning.fill("#recipe-name", "mine.mlx")
    tuning.click("#save")
    tuning.wait_for_selector("#problem:not([hidden])")
    assert "is there already" in tuning.locator("#problem").inner_text()


def test_a_failure_on_the_whole_scan_is_told_during_another_run(tuning: Any) -> None:
    """The message is shown although the page follows the run of a change since then."""
    tuning.evaluate("() => { state.current = 2; answers.failed({ run: 0, message: 'the disk is full' }); }")
    assert tuning.locator("#problem").inner_text() == "the disk is full"


def test_what_cannot_be_saved_leaves_a_run_alone(tuning: Any) -> None:
    """The message is shown, and the run can still be stopped."""
    tuning.evaluate("() => { running(true, 'running on the whole scan'); answers.problem({ message: 'it is there already' }); }")
    assert tuning.locator("#problem").inner_text() == "it is there already"
    assert tuning.locator("#state").inner_text() == "running on the whole scan"
    assert tuning.locator("#stop").is_enabled()


def test_a_result_that_comes_after_a_change_is_grey(tuning: Any) -> None:
    """The change may still wait to be sent; then the result has other settings than the controls."""
    told = "{ is: 'result', asked: state.asked, seconds: 1, warnings: [], tried: [] }"
    for change, grey in (("", False), ("ask(1e6);", True)):
        tuning.evaluate(f"() => {{ {change} return receive({told}, state.result); }}")
        assert tuning.evaluate("() => document.querySelector('.result').classList.contains('stale')") == grey


def test_settings_of_other_steps_are_not_set(tuning: Any) -> None:
    """A recipe that got another number of steps since the page was loaded comes with its own values."""
    tuning.evaluate("() => sessionStorage.setItem(location.pathname, JSON.stringify({ recipe: state.recipe, steps: [] }))")
    tuning.reload()
    tuning.wait_for_selector("body[data-measured='1']")


#: serves a scan as one that is large, so that it is tuned on a part
LARGE = """
import socket
import sys
from pathlib import Path
from pymeshfair.tuning.bench import prepared_scan
from pymeshfair.tuning.server import serve
folder = Path(sys.argv[2])
scan = prepared_scan(Path(sys.argv[1]), most=1000, part=400)
listening = socket.create_server(("127.0.0.1", 0))
address = f"http://127.0.0.1:{listening.getsockname()[1]}/token/"
serve(scan, "smooth_taubin", "token", folder, listening, ready=lambda: print(address, flush=True))
"""


@pytest.mark.slow
def test_a_large_scan_is_tuned_on_a_part(browser: Any, served: Served, errors: list[str], tmp_path: Path) -> None:
    """A large scan is shown and run in part."""
    command = [sys.executable, "-c", LARGE, str(served.folder / "scan.ply"), str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process, ExitStack() as stack:
        stack.callback(process.kill)
        assert process.stdout is not None
        page = browser.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.goto(process.stdout.readline().strip())
        page.wait_for_selector("body[data-measured='1']")
        counts = page.locator("th:text-is('vertices')").locator("xpath=..").locator("td")
        scan, result = (int(text.replace(",", "")) for text in counts.all_inner_texts()[:2])
        assert scan == result
        assert 380 <= scan <= 420
        page.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
    assert errors == []


def status_of(served: Served, path: str, headers: dict[str, str]) -> int:
    """The answer to a request of this path with these headers."""
    place = urlsplit(served.address)
    connection = http.client.HTTPConnection(place.hostname or "", place.port, timeout=20)
    connection.request("GET", path, headers=headers)
    status = connection.getresponse().status
    connection.close()
    return status


def test_who_does_not_know_the_token_is_refused(served: Served) -> None:
    """Without the token, with another one, from another origin or under another name every request ends with 403."""
    place = urlsplit(served.address)
    assert place.hostname == "127.0.0.1"
    assert status_of(served, place.path, {}) == 200
    assert status_of(served, "/", {}) == 403
    assert status_of(served, f"/{'x' * 43}/", {}) == 403
    assert status_of(served, place.path, {"Origin": "http://evil.example"}) == 403
    assert status_of(served, place.path, {"Host": "evil.example"}) == 403


@pytest.mark.parametrize(
    ("path", "origin"), [("{token}", "http://evil.example"), ("{token}", None), ("/wrong/", "http://{host}")]
)
def test_sockets_are_refused_as_well(served: Served, path: str, origin: str | None) -> None:
    """A page of another site cannot open the socket, even if it knew the token; nor does a page without it."""
    place = urlsplit(served.address)
    address = f"ws://{place.netloc}{path.format(token=place.path)}socket"
    given: Any = None if origin is None else origin.format(host=place.netloc)
    with pytest.raises(InvalidStatus) as caught, connect(address, origin=given):
        pass
    assert caught.value.response.status_code == 403
