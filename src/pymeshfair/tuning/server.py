"""Serves the tuning page: shows a recipe as controls, and exchanges JSON documents and binary meshes over one web socket."""

import asyncio
import contextlib
import hmac
import json
import logging
import re
import signal
import socket
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from html import escape
from http import HTTPStatus
from pathlib import Path
from typing import Any

from websockets.asyncio import server as websockets
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from ..declaration import AUTO, Bool, Enum, Float, Int, Length, Parameter, Percentage, Shot, String
from ..errors import ParameterError, PymeshfairError
from ..files.outputs import same_file
from ..operating_system import this_system
from ..recipe import Recipe, load_recipe, shipped_heads, shipped_recipes
from ..report.page import render
from ..running.job import Job
from ..running.supervise import run_job
from ..scripts.changing import with_parameter
from ..scripts.script import Script
from ..scripts.values import number_text
from ..scripts.write import write_script
from .bench import Result, Scan, Stopped, Workshop, stoppable

#: the headers of all pages: browsers store no page, and tell no other site its address, which has the token
_HEADERS = (
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
)


class ChoiceError(ParameterError):
    """The page sent a value that the parameter does not allow."""

    def __init__(self, step: int, parameter: str, reason: str) -> None:
        super().__init__(reason)
        self.step = step  # from 0
        self.parameter = parameter


def controls(recipe: Recipe) -> dict[str, Any]:
    """Returns the recipe as JSON types: its texts, and for each step the controls of its parameters, except cameras."""
    info = recipe.info
    return {
        "name": recipe.name,
        "purpose": info.purpose,
        "tune": info.tune,
        "steps": [
            {
                "name": step.filter.name,
                "summary": step.filter.summary,
                "parameters": [_control(p, step.values.get(p.name)) for p in step.filter.parameters if not isinstance(p, Shot)],
            }
            for step in (step.with_defaults() for step in recipe.script.steps)
        ],
    }


def script_with(script: Script, settings: Sequence[Any]) -> tuple[Script, tuple[str, ...]]:
    """Returns the switched-on steps of a script with the page's values, and the changes as texts to `override` these steps.

    Values are texts by parameter name, as for `parse_value`; an empty text keeps the script's value, except for a `String`.
    Raises `ChoiceError` for a wrong value.
    """
    if len(settings) != len(script.steps):
        raise ParameterError(f"the page has settings for {len(settings)} steps, the recipe has {len(script.steps)}")
    kept, overrides = [], list[str]()
    for index, (step, setting) in enumerate(zip(script.steps, settings, strict=True)):
        values = setting.get("values") if isinstance(setting, dict) else None
        if not isinstance(values, dict) or not all(isinstance(text, str) for text in values.values()):
            raise ParameterError("the page sent settings of a wrong form")
        if setting.get("on") is not True:
            continue
        kept.append(index)
        current = step.with_defaults().values
        for name, text in values.items():
            if text == value_text(current.get(name)):
                continue  # an unchanged value stays linked to its recipe setting, if it has one
            if text == "" and not isinstance(step.filter.parameter(name), String):
                continue  # keep the script's value; a parameter without a value gets the filter's default
            try:
                script = with_parameter(script, str(index + 1), name, text)
            except ParameterError as error:
                raise ChoiceError(index, name, str(error)) from error
            overrides.append(f"{len(kept)}.{name}={text}")
    if not kept:
        raise ParameterError("every step is switched off: switch one on")
    return script.with_steps(script.steps[index] for index in kept), tuple(overrides)


def in_mesh_units(script: Script, diagonal: float, mean_edge: float) -> Script:
    """Returns the script with all lengths in mesh units, so that they are the same on a part of the scan."""
    steps = script.with_defaults().steps
    return script.with_steps(step.in_mesh_units(diagonal=diagonal, mean_edge=mean_edge) for step in steps)


def saved_comment(recipe: Recipe, scan: str, note: str) -> str:
    """Returns the head comment of a tuned recipe."""
    title = f"{_plain(recipe.title)}, tuned on {_plain(scan)}"
    origin = f"Tuned with `pymeshfair tune`, from the recipe {_plain(recipe.name)}."
    notes = [_plain(note)] if note.strip() else []
    return "\n\n".join([title, origin, *notes, recipe.description]).strip()


def _plain(text: str) -> str:
    """Returns a text that is valid in an XML comment."""
    printable = "".join(letter if letter.isprintable() else " " for letter in text)
    return re.sub("-(?=-)", "- ", printable).rstrip("-")


def _control(parameter: Parameter, value: Any) -> dict[str, Any]:
    kind: dict[str, Any] = {"kind": "text"}
    if isinstance(parameter, Bool):
        kind = {"kind": "switch"}
    elif isinstance(parameter, Enum):
        kind = {"kind": "menu", "choices": list(parameter.choices)}
    elif isinstance(parameter, Percentage):
        shown = parameter.default if value == AUTO else value  # the default gives the range of the slider
        kind = {"kind": "length", **_bounds(parameter.minimum, None, shown.amount if isinstance(shown, Length) else 0.0)}
    elif isinstance(parameter, Int | Float):
        bounds = _bounds(parameter.minimum, parameter.maximum, value if isinstance(value, int | float) else 0)
        kind = {"kind": "whole" if isinstance(parameter, Int) else "number", **bounds}
    return {
        "name": parameter.name,
        "label": parameter.label or parameter.name,
        "help": parameter.help,
        "allowed": parameter.describe_allowed(),
        "advanced": parameter.advanced,
        "automatic": AUTO if parameter.automatic is not None else None,
        "value": value_text(value),
        **kind,
    }


def _bounds(minimum: float | None, maximum: float | None, value: float) -> dict[str, Any]:
    """Returns the limits of a field and of its slider; they differ if a limit is missing or the maximum is far from the value."""
    reach = max(4.0 * abs(value), 10.0 if value == 0 or abs(value) >= 2 else 1.0)
    return {
        "low": minimum if minimum is not None else min(0.0, value - reach),
        "high": maximum if maximum is not None and maximum <= 100.0 * reach else reach,
        "least": minimum,
        "most": maximum,
    }


def value_text(value: Any) -> str:
    """Returns the text of a checked value for `parse_value`; empty for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return number_text(value)
    if isinstance(value, tuple):
        return ",".join(value_text(part) for part in value)
    return str(value)


def redirecting_file(address: str, folder: Path) -> Path:
    """Writes a page that redirects to an address, and that only this user can read.

    Every user of the machine can read the browser's command line: it names this page, not the address with the token.
    """
    path, where = folder / "open.html", escape(address)
    path.touch(0o600, exist_ok=False)
    page = f'<!DOCTYPE html>\n<meta http-equiv="refresh" content="0; url={where}">\n<a href="{where}">pymeshfair tune</a>\n'
    path.write_text(page, "utf-8")
    return path


def is_allowed(request: Request, token: str) -> bool:
    """Returns whether a request may be answered.

    The path must begin with the token. The ``Host`` header must be a name of this machine, against DNS rebinding. An ``Origin``
    header must name the same host; a request for the socket must have this header, which browsers always send there.
    """
    start = f"/{token}/".encode()
    hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
    if not hmac.compare_digest(request.path.encode("utf-8", "replace")[: len(start)], start) or len(hosts) != 1:
        return False
    has_origin = bool(origins) or not request.path.endswith("/socket")
    this_machine = re.fullmatch(r"(127\.0\.0\.1|localhost|\[::1\])(:\d+)?", hosts[0], re.IGNORECASE)
    return bool(this_machine) and has_origin and all(origin == f"http://{hosts[0]}" for origin in origins)


def _response(status: HTTPStatus, kind: str, body: bytes) -> Response:
    headers = Headers([("Content-Type", kind), ("Content-Length", str(len(body))), ("Connection", "close"), *_HEADERS])
    return Response(status.value, status.phrase, headers, body)


def serve(
    scan: Scan, recipe: str, token: str, folder: Path, listening: socket.socket, *, ready: Callable[[], None] = lambda: None
) -> None:
    """Answers requests until Ctrl-C or a signal ends the process; then ends the worker.

    `recipe` is the name or path of the recipe that the page shows first, `token` is the first part of every path, and `folder` is
    for temporary files. `ready` is called when the server accepts requests.
    """
    workshop = Workshop(scan, folder)
    page = render("tune.html", scripts=("viewer.js", "tune.js"), sockets=True, title=scan.path.name)
    current: list[Conversation] = []

    def answer(connection: websockets.ServerConnection, request: Request) -> Response | None:
        """None lets the page open its socket."""
        if not is_allowed(request, token):
            refusal = b"403: this page needs the address that pymeshfair tune printed\n"
            return _response(HTTPStatus.FORBIDDEN, "text/plain", refusal)
        if request.path == f"/{token}/socket":
            return None
        if request.path.partition("?")[0] == f"/{token}/":
            return _response(HTTPStatus.OK, "text/html; charset=utf-8", page.encode("utf-8", "replace"))
        return _response(HTTPStatus.NOT_FOUND, "text/plain", b"404: there is no such page\n")

    async def converse(connection: websockets.ServerConnection) -> None:
        for former in current:  # only the page that was opened last is served
            await former.end()
        current[:] = [Conversation(connection, scan, recipe, workshop)]
        await current[0].serve_page()

    async def serving() -> None:
        logger = logging.getLogger("pymeshfair.tuning")
        logger.setLevel(logging.CRITICAL)  # browsers open connections in advance, and abandon some
        service = websockets.serve(
            converse, sock=listening, process_request=answer, max_size=1 << 20, compression=None, logger=logger, close_timeout=2
        )
        try:
            async with service as server:
                ready()
                await server.serve_forever()
        finally:
            await workshop.close()

    for name in this_system().stop_signals:
        if name != "SIGINT":
            signal.signal(getattr(signal, name), lambda number, _: sys.exit(128 + number))
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells make background processes ignore SIGINT
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(serving())


class Conversation:
    """The conversation with one page; `first` is the name or path of the recipe that the page shows first."""

    def __init__(self, connection: websockets.ServerConnection, scan: Scan, first: str, workshop: Workshop) -> None:
        self._connection = connection
        self._scan, self._first = scan, first
        self._workshop = workshop
        self._recipes: dict[str, Recipe] = {}
        self._number = 0
        self._sending = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()
        self._finish_stopped = threading.Event()  # stops the run of `finish` at its next event
        self._finishing = asyncio.Lock()  # held by a run of `finish`; the next one waits for its end
        self._replaced = False

    async def serve_page(self) -> None:
        """Carries out the orders of the page until it is closed."""
        handlers = (self.welcome, self.recipe, self.run, self.stop, self.save, self.finish)
        handler_of = {handler.__name__: handler for handler in handlers}
        order: Any = {"do": "welcome"}
        try:
            while True:
                try:
                    await handler_of[order["do"]](order)
                except (PymeshfairError, OSError) as error:
                    location: dict[str, Any] = {}
                    if isinstance(error, ChoiceError):
                        location = {"step": error.step, "parameter": error.parameter}
                    await self._send("problem", message=str(error), asked=order.get("asked"), **location)
                except (KeyError, TypeError, ValueError):
                    await self._send("problem", message="the page sent an unknown request; load the page again")
                order = json.loads(await self._connection.recv())
        except (ConnectionClosed, ValueError):
            pass  # the page is closed, or is no page of this server
        finally:
            self._finish_stopped.set()
            for task in list(self._tasks):
                task.cancel()
            if not self._replaced:  # else the workshop already works for another page
                await self.stop({})

    async def end(self) -> None:
        """Stops the current run, and tells this page that another page has replaced it."""
        self._replaced = True
        await self.stop({})
        await self._send("ended", message="Another page was opened for this scan; this page is no longer updated.")
        await self._connection.close()

    async def welcome(self, order: Mapping[str, Any]) -> None:
        scan = self._scan
        recipes = [{"name": head.name, "title": head.info.title} for head in shipped_heads()]
        if self._first not in shipped_recipes():
            recipes.insert(0, {"name": self._first, "title": Path(self._first).name})
        await self._send(
            "welcome",
            scan=scan.path.name,
            vertices=scan.vertices,
            has_part=scan.part is not None,
            diagonal=scan.diagonal,
            mean_edge=scan.mean_edge,
            recipes=recipes,
            folder=str(Path.cwd()),
            warnings=list(scan.warnings),
        )
        await self.recipe({"recipe": self._first})
        opening, scene = await self._workshop.open()
        await self._send("scan", scene, **opening)

    async def recipe(self, order: Mapping[str, Any]) -> None:
        name = str(order["recipe"])
        if name not in (*shipped_recipes(), self._first):
            raise ParameterError(f"there is no recipe {name!r}")
        self._recipes[name] = self._recipes.get(name) or load_recipe(name)
        await self._send("recipe", key=name, **controls(self._recipes[name]))

    async def run(self, order: Mapping[str, Any]) -> None:
        recipe, overrides = self._tuned(order)
        if (scan := self._scan).part is not None:
            recipe = replace(recipe, script=in_mesh_units(recipe.script, scan.diagonal, scan.mean_edge))
        self._number += 1
        about: dict[str, Any] = {"run": self._number, "asked": order.get("asked")}
        await self._send("begun", **about)
        running = await self._workshop.begin(recipe, overrides, self._event_sender(self._number))
        self._start(self._send_results(running, about))

    async def _send_results(self, running: asyncio.Task[Result], about: Mapping[str, Any]) -> None:
        try:
            numbers, scene = await asyncio.shield(running)
            await self._send("result", scene, **about, **numbers)
            numbers, scene = await asyncio.shield(await self._workshop.measure(running))
            await self._send("numbers", scene, **about, **numbers)
        except (asyncio.CancelledError, Stopped) as error:
            if isinstance(error, Stopped) or running.cancelled():
                await self._send("cancelled", **about)
        except (PymeshfairError, OSError) as error:
            await self._send("failed", **about, message=str(error))

    async def stop(self, order: Mapping[str, Any]) -> None:
        self._finish_stopped.set()
        await self._workshop.stop()

    async def save(self, order: Mapping[str, Any]) -> None:
        path, overwrite = self._target(order, ".mlx"), order.get("replace") is True
        recipe, _ = self._tuned(order)
        if path.exists() and not overwrite:
            raise ParameterError(f"{path.name} is there already: give another name, or tick that it may be replaced")
        scan = self._scan
        script = replace(recipe.script, comment=saved_comment(recipe, scan.path.name, str(order.get("note", ""))))
        write_script(script, path, diagonal=scan.diagonal, mean_edge=scan.mean_edge, overwrite=overwrite)
        await self._send("saved", path=str(path))

    async def finish(self, order: Mapping[str, Any]) -> None:
        """Runs the tuned recipe on the whole scan."""
        path = self._target(order)
        recipe, overrides = self._tuned(order)
        scan = self._scan.path
        if same_file(path, scan):
            raise ParameterError(f"{path.name} is the scan, which must stay as it is: give another name")
        await self.stop(order)
        recipe = replace(recipe, script=replace(recipe.script, comment=saved_comment(recipe, scan.name, ""), path=None))
        job = Job(recipe, scan, path, overwrite=order.get("replace") is True, overrides=overrides, command=tuple(sys.argv))
        stopped = self._finish_stopped = threading.Event()
        on_event = stoppable(stopped.is_set, self._event_sender(0))

        async def work() -> None:
            try:
                async with self._finishing:
                    result = await asyncio.to_thread(run_job, job, on_event)
                files = [str(file) for file in (result.output, *result.side_files, result.provenance)]
                told: dict[str, Any] = {"kind": "finished", "files": files, "warnings": list(result.warnings)}
            except Stopped:
                told = {"kind": "cancelled"}
            except (PymeshfairError, OSError) as error:
                told = {"kind": "failed", "message": str(error)}
            if self._finish_stopped is stopped:  # else the page follows a later run of `finish`
                await self._send(run=0, **told)

        await self._send("begun", run=0)
        self._start(work())

    def _tuned(self, order: Mapping[str, Any]) -> tuple[Recipe, tuple[str, ...]]:
        recipe = self._recipes[str(order["recipe"])]
        script, overrides = script_with(recipe.script, order["steps"])
        return replace(recipe, script=script), overrides

    def _target(self, order: Mapping[str, Any], extension: str = "") -> Path:
        name = str(order["name"]).strip()
        if not name or Path(name).name != name or name in (".", ".."):
            raise ParameterError(f"{name!r} is no name of a file: give it without a folder")
        return Path.cwd() / (name if name.casefold().endswith(extension) else name + extension)

    def _event_sender(self, number: int) -> Callable[[Any], None]:
        loop = asyncio.get_running_loop()

        def send_event(event: Any) -> None:
            document = {"event": type(event).__name__, **asdict(event)}
            loop.call_soon_threadsafe(lambda: self._start(self._send("event", run=number, **document)))

        return send_event

    def _start(self, work: Any) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _send(self, kind: str, scene: bytes | None = None, **more: Any) -> None:
        async with self._sending:
            with contextlib.suppress(ConnectionClosed):
                await self._connection.send(json.dumps({"is": kind, **more}))
                if scene is not None:
                    await self._connection.send(scene)
