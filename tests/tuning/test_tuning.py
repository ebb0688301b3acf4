"""The page to tune on, as far as it needs no browser: who may reach it, settings, and parts of large scans."""

from __future__ import annotations

import asyncio
import gc
import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from websockets.datastructures import Headers
from websockets.http11 import Request

from pymeshfair.declaration import Length
from pymeshfair.errors import ParameterError
from pymeshfair.files.outputs import Writing
from pymeshfair.files.ply_write import write_ply
from pymeshfair.files.three_mf import write_3mf
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import Recipe, load_recipe, shipped_recipes
from pymeshfair.registry import find_filter
from pymeshfair.running.job import Job
from pymeshfair.running.read import read_mesh
from pymeshfair.running.supervise import run_job
from pymeshfair.scripts.changing import override
from pymeshfair.scripts.read import parse_script
from pymeshfair.scripts.script import Script, Step
from pymeshfair.scripts.write import format_script
from pymeshfair.tuning.bench import STOP, Bench, Scan, Stopped, Workshop, part_of, prepared_scan
from pymeshfair.tuning.server import ChoiceError, Conversation, controls, in_mesh_units, is_allowed, saved_comment, script_with
from tests.meshes import icosphere


def sent(recipe: str) -> list[dict[str, Any]]:
    """What a page sends back that changed nothing."""
    steps = controls(load_recipe(recipe))["steps"]
    return [{"on": True, "values": {p["name"]: p["value"] for p in step["parameters"]}} for step in steps]


@pytest.mark.parametrize("name", shipped_recipes())
def test_a_page_that_changes_nothing_gives_the_recipe(name: str) -> None:
    """What the controls show comes back as the same script, number by number."""
    recipe = load_recipe(name)
    back, changed = script_with(recipe.script, sent(name))
    assert format_script(back) == format_script(recipe.script)
    assert changed == ()


def test_controls_follow_the_declaration() -> None:
    """Lengths have a unit, numbers their bounds, words a menu, switches a tick, and all of them their help."""
    (step,) = controls(load_recipe("smooth_implicit"))["steps"]
    kinds = {p["name"]: p["kind"] for p in step["parameters"]}
    assert kinds["detail_size"] == "length"
    assert kinds["iterations"] == "whole"
    assert kinds["operator"] == "menu"
    assert kinds["preserve_volume"] == "switch"
    for parameter in step["parameters"]:
        assert parameter["help"]
        if "low" in parameter:
            assert parameter["low"] < parameter["high"]
            if parameter["value"] in ("", "auto"):  # found by the filter
                continue
            number = float(parameter["value"].removesuffix("edge").removesuffix("%"))
            assert parameter["low"] <= number <= parameter["high"]


def test_what_is_automatic_is_auto_on_the_page() -> None:
    """The controls of such parameters show "auto" and take it back; the script that is saved has MeshLab's numbers."""
    recipe = load_recipe("denoise")
    (step,) = controls(recipe)["steps"]
    texts = {p["name"]: p["value"] for p in step["parameters"] if p["automatic"]}
    assert len(texts) == 7
    assert set(texts.values()) == {"auto"}
    changed, _ = script_with(recipe.script, [{"on": True, "values": {"relaxation": "3"}}])
    back, _ = script_with(changed, [{"on": True, "values": {"relaxation": "auto"}}])
    assert back.steps == recipe.script.steps
    assert 'name="relaxation" value="-1"' in format_script(recipe.script)


def test_wrong_settings_say_where() -> None:
    """A value that is not allowed names step and parameter; steps can be left out, but not all of them."""
    script = load_recipe("clean_range_map").script
    given: list[dict[str, Any]] = [{"on": True, "values": {}} for _ in script.steps]
    given[-1]["values"] = {"iterations": "-1"}
    with pytest.raises(ChoiceError, match="whole number") as caught:
        script_with(script, given)
    assert (caught.value.step, caught.value.parameter) == (len(script.steps) - 1, "iterations")
    given[-1] = {"on": False, "values": {}}
    assert script_with(script, given)[0].steps == script.steps[:-1]
    with pytest.raises(ParameterError, match="every step is switched off"):
        script_with(script, [{"on": False, "values": {}}] * len(script.steps))
    with pytest.raises(ParameterError, match="settings for 1 steps"):
        script_with(script, given[:1])
    for wrong in (3, {"on": True}, {"on": True, "values": {"a": 1}}):
        with pytest.raises(ParameterError, match="settings of a wrong form"):
            script_with(script, [*given[:-1], wrong])


def test_a_changed_value_is_recorded_with_the_number_of_its_step_in_the_recorded_recipe() -> None:
    """Steps that are switched off are not counted, as the recipe in the record does not have them."""
    script = load_recipe("clean_range_map").script
    given: list[dict[str, Any]] = [{"on": k > 0, "values": {}} for k in range(len(script.steps))]
    given[-1]["values"] = {"iterations": "7"}
    kept, overrides = script_with(script, given)
    assert overrides == (f"{len(script.steps) - 1}.iterations=7",)
    assert override(kept, overrides) == kept


def test_numbers_are_in_the_unit_of_the_recipe(tmp_path: Path) -> None:
    """Tables and colour bars name it if the scan's file names none, as in a run; a scan in another unit gives a run's warning."""
    trimesh.Trimesh(*icosphere(2), process=False).export(tmp_path / "scan.ply")
    recipe, bench = load_recipe("smooth_taubin"), Bench(tmp_path / "scan.ply", None)
    for unit, shown in (("mm", "mm"), ("", "mesh units"), ("ft", "ft")):
        job = Job(replace(recipe, script=replace(recipe.script, unit=unit)), tmp_path / "scan.ply", tmp_path / "result.ply")
        assert not any("the recipe is for scans in" in text for text in bench.run(job, tmp_path)[0]["warnings"])
        numbers, scene = bench.measure(tmp_path)
        assert numbers["distance"][0][1] == shown
        assert f"distance from the first surface ({shown}, outwards above 0)".encode() in scene
    vertices, faces = icosphere(2)
    with (tmp_path / "scan.3mf").open("xb") as file:
        write_3mf(MeshData(vertices=vertices, faces=faces, unit="cm"), file, Writing(lambda: 0.0, {}, "", []))
    warnings = Bench(tmp_path / "scan.3mf", None).run(job, tmp_path)[0]["warnings"]
    assert any("the recipe is for scans in ft, and this scan is in cm" in text for text in warnings)


def test_lengths_on_a_part_are_those_of_the_whole() -> None:
    """Percent and edges become mesh units of the whole scan, defaults that nobody gave as well."""
    given = load_recipe("spectral_low_pass").script
    script = in_mesh_units(given, diagonal=200.0, mean_edge=0.5)
    assert given.steps[0].values["detail_size"].unit == "edge"
    assert script.steps[0].values["detail_size"] == Length(given.steps[0].values["detail_size"].amount * 0.5)
    assert all(v.unit == "absolute" for v in script.steps[0].values.values() if isinstance(v, Length))


def test_the_head_of_a_saved_recipe_can_be_read_back() -> None:
    """Names and notes with what a comment must not hold are written so that the script is read as it was."""
    recipe = load_recipe("smooth_implicit")
    words = saved_comment(recipe, "a---b<!-- \x07.ply", "softer -- --> end -")
    assert "tuned on a" in words
    nameless = replace(recipe, name="a--b", script=replace(recipe.script, comment=""))
    assert format_script(replace(nameless.script, comment=saved_comment(nameless, "scan.ply", "")))
    script = replace(recipe.script, comment=words)
    assert parse_script(format_script(script).encode(), "x.mlx").steps == recipe.script.with_defaults().steps


@pytest.mark.parametrize(
    ("path", "headers", "allowed"),
    [
        ("/secret/", [("host", "127.0.0.1:80")], True),
        ("/secret/", [("host", "localhost:80"), ("origin", "http://localhost:80")], True),
        ("/secret/", [("host", "[::1]:80")], True),
        ("/secret/", [("host", "localhost")], True),
        ("/secret/", [("host", "scanner.local:80")], False),
        ("/secre/", [("host", "127.0.0.1:80")], False),
        ("/", [("host", "127.0.0.1:80")], False),
        ("/secretly", [("host", "127.0.0.1:80")], False),
        ("/secret/", [], False),
        ("/secret/", [("host", "evil.example:80")], False),
        ("/secret/", [("host", "127.0.0.1.evil.example:80")], False),
        ("/secret/", [("host", "127.0.0.1:80"), ("origin", "http://evil.example")], False),
        ("/secret/", [("host", "127.0.0.1:80"), ("origin", "null")], False),
        ("/secret/", [("host", "127.0.0.1:80"), ("origin", "http://127.0.0.1:81")], False),
        ("/secret/", [("host", "127.0.0.1:80"), ("host", "127.0.0.1:80")], False),
    ],
)
@pytest.mark.parametrize("place", ["", "socket"])
def test_who_may_reach_the_page(path: str, headers: list[tuple[str, str]], allowed: bool, place: str) -> None:
    """The token, a host of this machine, and no other origin; a socket needs an origin."""
    request = Request(path + place, Headers(headers))
    has_origin = any(name == "origin" for name, _ in headers)
    assert is_allowed(request, "secret") == (allowed and (not place or has_origin))


def test_a_large_scan_is_tuned_on_a_part(tmp_path: Path) -> None:
    """The part has about as many vertices as asked for and is the foremost; a small scan is taken whole."""
    vertices, faces = icosphere(4)
    trimesh.Trimesh(vertices + np.array([1e5, 0.0, -1e5]), faces, process=False).export(tmp_path / "scan.stl")
    whole = prepared_scan(tmp_path / "scan.stl")
    assert whole.part is None
    cut = prepared_scan(tmp_path / "scan.stl", most=1000, part=400)
    assert cut.part == 400
    part = part_of(read_mesh(tmp_path / "scan.stl").mesh, cut.part)
    assert 380 <= len(part.vertices) <= 420
    assert part.vertices[:, 2].mean() > -1e5 + 0.7
    assert len(part.faces) > 600
    assert (cut.vertices, cut.diagonal) == (whole.vertices, whole.diagonal)


def test_a_stray_vertex_costs_the_page_no_resolution(tmp_path: Path) -> None:
    """The cube of the coordinates holds what is drawn: a far vertex without faces does not make it larger."""
    vertices, faces = icosphere(2)
    for name, points in (("ball", vertices), ("stray", np.vstack([vertices, [[1e6, 0.0, 0.0]]]))):
        trimesh.Trimesh(points, faces, process=False).export(tmp_path / f"{name}.ply")
    (centre, half), (of_ball, half_of_ball) = (Bench(tmp_path / f"{name}.ply", None)._box for name in ("stray", "ball"))
    assert (centre.tolist(), half) == (of_ball.tolist(), half_of_ball)


def test_what_was_changed_on_the_page_gives_the_warnings_of_a_run(tmp_path: Path) -> None:
    """A better recipe is named for noise if nothing was changed, as after `pymeshfair run`."""
    vertices, faces = icosphere(4)
    noise = np.random.default_rng(0).normal(scale=0.01, size=vertices.shape)
    trimesh.Trimesh(vertices + noise, faces, process=False).export(tmp_path / "scan.ply")
    scan = prepared_scan(tmp_path / "scan.ply")
    connection: Any = None  # nothing is sent
    conversation = Conversation(connection, scan, "smooth_implicit", Workshop(scan, tmp_path))
    conversation._recipes["smooth_implicit"] = load_recipe("smooth_implicit")
    bench, warned = Bench(scan.path, None), []
    for size in ("auto", "5edge"):
        order = {"recipe": "smooth_implicit", "steps": [{"on": True, "values": {"detail_size": size}}]}
        recipe, overrides = conversation._tuned(order)
        assert overrides == (() if size == "auto" else ("1.detail_size=5edge",))
        (tmp_path / size / "new").mkdir(parents=True)
        job = Job(recipe, scan.path, tmp_path / size / "result.ply", overrides=overrides)
        warned.append([text for text in bench.run(job, tmp_path / size)[0]["warnings"] if "denoise" in text])
    assert [len(texts) for texts in warned] == [1, 0]


def test_the_page_has_the_warnings_of_a_run(tmp_path: Path) -> None:
    """Warnings on the change of shape, on lost contents and on the steps are those of `pymeshfair run`, in the same words."""
    vertices, faces = icosphere(4)
    bumpy = vertices * (1.0 + 0.03 * np.sin(14.0 * vertices[:, :1]) * np.sin(14.0 * vertices[:, 1:2]))
    colors = np.full((len(vertices), 4), 200, np.uint8)
    with (tmp_path / "scan.ply").open("xb") as file:
        write_ply(MeshData(vertices=bumpy, faces=faces, vertex_attributes={"colors": colors}), file)
    smooth = Step(find_filter("apply_coord_explicit_smoothing"), {"iterations": 40})
    remesh = Step(find_filter("meshing_isotropic_explicit_remeshing"), {"iterations": 1})
    comment = "Smooth\n\nTask: smooth"
    for name, steps in (("smoothed", (smooth,)), ("remeshed", (smooth, remesh))):
        job = Job(Recipe(name, Script(steps, comment)), tmp_path / "scan.ply", tmp_path / f"{name}.ply")
        stage = tmp_path / name
        (stage / "new").mkdir(parents=True)
        bench = Bench(job.input, None)
        warnings = [*bench.run(job, stage)[0]["warnings"], *bench.measure(stage)[0]["warnings"]]
        assert sorted(warnings) == sorted(run_job(job).warnings)
        assert any("of the relief apart from noise is gone" in text for text in warnings) == (name == "smoothed")


@dataclass
class Listener:
    """A connection that keeps what was sent, apart from events."""

    told: list[dict[str, Any]] = field(default_factory=list)
    reading: asyncio.Event = field(default_factory=asyncio.Event)  # set while a run reads its scan

    async def send(self, text: str) -> None:
        """Keep a message."""
        message = json.loads(text)
        if message["is"] == "event":
            self.reading.set()
        else:
            self.told.append(message)


def test_a_second_run_on_the_whole_scan_replaces_the_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It waits until the first has ended, writes the file, and the page is told of the end of the second alone."""
    monkeypatch.chdir(tmp_path)
    trimesh.Trimesh(*icosphere(4), process=False).export(tmp_path / "scan.ply")
    scan = prepared_scan(tmp_path / "scan.ply")
    order = {"recipe": "smooth_implicit", "steps": [{"on": True, "values": {}}], "name": "out.ply"}

    async def finish_twice() -> list[dict[str, Any]]:
        listener: Any = Listener()
        conversation = Conversation(listener, scan, "smooth_implicit", Workshop(scan, tmp_path))
        conversation._recipes["smooth_implicit"] = load_recipe("smooth_implicit")
        await conversation.finish(order)
        await listener.reading.wait()
        await conversation.finish(order)
        while conversation._tasks:
            await asyncio.sleep(0.01)
        told: list[dict[str, Any]] = listener.told
        return told

    told = asyncio.run(finish_twice())
    assert [message["is"] for message in told] == ["begun", "begun", "finished"]
    assert told[-1]["files"][0] == str(tmp_path / "out.ply")


def test_a_stop_between_mesh_and_numbers_is_told(tmp_path: Path) -> None:
    """The page learns that it need not wait for the numbers."""
    scan = Scan(tmp_path / "scan.ply", 3, 1.0, 1.0, None, ())

    async def stopped_late() -> list[str]:
        listener: Any = Listener()
        conversation = Conversation(listener, scan, "smooth_implicit", Workshop(scan, tmp_path))
        running: Any = asyncio.get_running_loop().create_future()
        running.set_result(({"tried": []}, None))
        await conversation._send_results(running, {"run": 1})
        return [message["is"] for message in listener.told]

    assert asyncio.run(stopped_late()) == ["result", "cancelled"]


def test_the_end_of_a_run_whose_page_was_closed_is_not_printed(tmp_path: Path) -> None:
    """Nobody waits for such a run, and asyncio prints exceptions that nobody took."""

    async def printed() -> list[Any]:
        contexts = list[Any]()
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: contexts.append(context))
        workshop = Workshop(Scan(tmp_path / "scan.ply", 3, 1.0, 1.0, None, ()), tmp_path)

        async def run() -> Any:
            while not (tmp_path / STOP).exists():
                await asyncio.sleep(0.01)
            raise Stopped("stopped")

        workshop._task = asyncio.create_task(run())
        await workshop.stop()
        gc.collect()
        return contexts

    assert asyncio.run(printed()) == []


def test_the_scan_is_no_output(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run on the whole scan refuses to replace the scan, also under the name of a link, and if files may be replaced."""
    monkeypatch.chdir(tmp_path)
    trimesh.Trimesh(*icosphere(1), process=False).export(tmp_path / "scan.ply")
    (tmp_path / "link.ply").hardlink_to(tmp_path / "scan.ply")
    scan = prepared_scan(tmp_path / "scan.ply")
    connection: Any = None  # nothing is sent
    conversation = Conversation(connection, scan, "smooth_taubin", Workshop(scan, tmp_path))
    conversation._recipes["smooth_taubin"] = load_recipe("smooth_taubin")
    for name in ("scan.ply", "link.ply"):
        order = {"recipe": "smooth_taubin", "steps": sent("smooth_taubin"), "name": name, "replace": True}
        with pytest.raises(ParameterError, match=f"{name} is the scan, which must stay as it is: give another name"):
            asyncio.run(conversation.finish(order))
