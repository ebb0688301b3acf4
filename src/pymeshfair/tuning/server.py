"""Serves the page, a recipe as controls, and talks with it through one socket: JSON documents, and meshes as bytes.

Access is by a token, from a page of the server itself, under a name of this machine.
"""

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
from ..operating_system import this_system
from ..recipe import Recipe, load_recipe, shipped_heads, shipped_recipes
from ..report.page import render
from ..running.job import Event, Job
from ..running.supervise import run_job
from ..scripts.script import Script, Step
from ..scripts.values import number_text, parse_value
from ..scripts.write import write_script
from .bench import Result, Scan, Stopped, Workshop

#: of every answer: browsers keep nothing and tell other sites nothing
_HEADERS = (
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
)


# ------------------------------------------------------------------------------------------------ a recipe as controls, and back


class ChoiceError(ParameterError):
    """A value that a parameter does not allow."""

    def __init__(self, step: int, parameter: str, reason: str) -> None:
        super().__init__(reason)
        self.step = step  # its number, from 0
        self.parameter = parameter  # its name


def controls(recipe: Recipe) -> dict[str, Any]:
    """The recipe in terms of JSON: its words, and for each step and parameter what a control needs."""
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


def script_with(script: Script, settings: Sequence[Any]) -> Script:
    """The script with the steps that are on, and with the values that a page sent; a `ChoiceError` names one that is wrong.

    Values are texts by parameter name, in the form that `parse_value` reads, empty where MeshLab is to find the value.
    """
    if len(settings) != len(script.steps):
        raise ParameterError(f"the page has settings for {len(settings)} steps, the recipe has {len(script.steps)}")
    steps = []
    for number, (step, setting) in enumerate(zip(script.steps, settings, strict=True)):
        values = setting.get("values") if isinstance(setting, dict) else None
        if not isinstance(values, dict) or not all(isinstance(text, str) for text in values.values()):
            raise ParameterError("the page sent settings that are none")
        if setting.get("on") is True:
            steps.append(_set(number, step, values))
    if not steps:
        raise ParameterError("every step is switched off: switch one on")
    return script.with_steps(steps)


def in_mesh_units(script: Script, diagonal: float, mean_edge: float) -> Script:
    """The script with all its lengths in mesh units, so that on a part of a scan they are those of the whole."""
    steps = script.with_defaults().steps
    return script.with_steps(step.in_mesh_units(diagonal=diagonal, mean_edge=mean_edge) for step in steps)


def saved_comment(recipe: Recipe, scan: str, note: str) -> str:
    """The head comment of a tuned recipe: what it was made of, and the words of the original."""
    title = f"{recipe.title}, tuned on {_plain(scan)}"
    origin = f"Tuned with `pymeshfair tune`, from the recipe {_plain(recipe.name)}."
    notes = [_plain(note)] if note.strip() else []
    return "\n\n".join([title, origin, *notes, recipe.description]).strip()


def _plain(text: str) -> str:
    """Words that an XML comment may hold."""
    return "".join(letter if letter.isprintable() else " " for letter in text).replace("--", "- -").rstrip("-")


def _set(number: int, step: Step, setting: Mapping[str, str]) -> Step:
    values = {}
    shown = step.with_defaults().values
    for name, text in setting.items():
        if text == value_text(shown.get(name)):
            continue  # an unchanged value keeps the setting of the recipe that it comes from
        try:
            parameter = step.filter.parameter(name)
            if text == "" and not isinstance(parameter, String):
                continue  # what MeshLab finds for the mesh
            values[name] = parse_value(parameter, text)
        except ParameterError as error:
            raise ChoiceError(number, name, str(error)) from error
    return step.with_checked(values)


def _control(parameter: Parameter, value: Any) -> dict[str, Any]:
    kind: dict[str, Any] = {"kind": "text"}
    if isinstance(parameter, Bool):
        kind = {"kind": "switch"}
    elif isinstance(parameter, Enum):
        kind = {"kind": "menu", "choices": list(parameter.choices)}
    elif isinstance(parameter, Percentage):
        shown = parameter.default if value == AUTO else value  # the slider has the reach of the filter's own default
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
    """The ends of a slider; where the declaration sets none, far enough from the value. The field beside it takes more."""
    reach = max(4.0 * abs(value), 10.0 if value == 0 or abs(value) >= 2 else 1.0)
    return {
        "low": minimum if minimum is not None else min(0.0, value - reach),
        "high": maximum if maximum is not None and maximum <= 100.0 * reach else reach,
        "least": minimum,
        "most": maximum,
    }


def value_text(value: Any) -> str:
    """A checked value in the form that `parse_value` reads; empty for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return number_text(value)
    if isinstance(value, tuple):
        return ",".join(value_text(part) for part in value)
    return str(value)


# -------------------------------------------------------------------------------------------------------------- who is answered


def redirecting_file(address: str, folder: Path) -> Path:
    """A file that leads a browser to an address, and that this user alone can read.

    The address holds the token, and every user of the machine can read the browser's command line.
    """
    path, where = folder / "open.html", escape(address)
    path.touch(0o600, exist_ok=False)
    page = f'<!DOCTYPE html>\n<meta http-equiv="refresh" content="0; url={where}">\n<a href="{where}">pymeshfair tune</a>\n'
    path.write_text(page, "utf-8")
    return path


def is_allowed(request: Request, token: str) -> bool:
    """Whether a request has the token, the right host and the right origin.

    Its path begins with the token; the ``Host`` header is this machine, so that no other site's name leads here; and the
    ``Origin`` header, without which no browser opens a socket, is that host itself.
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
    scan: Scan,
    recipe: str,
    token: str,
    folder: Path,
    listening: socket.socket,
    *,
    ready: Callable[[], None] = lambda: None,
) -> None:
    """Answer requests until Ctrl-C, or until the process is asked to end, which is done in order.

    `recipe` is the name or path of the first recipe, `token` the first part of every path, and `folder` for temporary files.
    `ready` is called once requests are answered.
    """
    workshop = Workshop(scan, folder)
    page = render("tune.html", scripts=("viewer.js", "tune.js"), sockets=True, title=scan.path.name)
    newest: list[Conversation] = []

    def answered(connection: websockets.ServerConnection, request: Request) -> Response | None:
        """The answer to a request; None lets the page open its socket."""
        if not is_allowed(request, token):
            refusal = b"403: this page needs the address that pymeshfair tune printed\n"
            return _response(HTTPStatus.FORBIDDEN, "text/plain", refusal)
        if request.path == f"/{token}/socket":
            return None
        if request.path.partition("?")[0] == f"/{token}/":
            return _response(HTTPStatus.OK, "text/html; charset=utf-8", page.encode("utf-8", "replace"))
        return _response(HTTPStatus.NOT_FOUND, "text/plain", b"404: there is no such page\n")

    async def talk(connection: websockets.ServerConnection) -> None:
        for former in newest:  # the page that was opened last is the one that is served
            await former.end()
        newest[:] = [Conversation(connection, scan, recipe, workshop)]
        await newest[0].held()

    async def serving() -> None:
        logger = logging.getLogger("pymeshfair.tuning")
        logger.setLevel(logging.CRITICAL)  # browsers open connections in advance, and give some of them up
        served = websockets.serve(
            talk, sock=listening, process_request=answered, max_size=1 << 20, compression=None, logger=logger, close_timeout=2
        )
        try:
            async with served as server:
                ready()
                await server.serve_forever()
        finally:
            await workshop.close()

    for name in this_system().stop_signals:
        if name != "SIGINT":
            signal.signal(getattr(signal, name), lambda number, _: sys.exit(128 + number))
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which shells take away from what they start in the background
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(serving())


# ------------------------------------------------------------------------------------------------------------------- what is said


class Conversation:
    """One page."""

    def __init__(self, connection: websockets.ServerConnection, scan: Scan, first: str, workshop: Workshop) -> None:
        """`first` is the name or path of the recipe that is shown first."""
        self._connection = connection
        self._scan, self._first = scan, first
        self._workshop = workshop
        self._recipes: dict[str, Recipe] = {}
        self._number = 0
        self._sending = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()
        self._finish_stopped = threading.Event()  # stops a run of the file into a file at its next sign of life
        self._replaced = False

    async def held(self) -> None:
        """Answer the page until it is closed."""
        works = (self.welcome, self.recipe, self.run, self.stop, self.save, self.finish)
        answers = {work.__name__: work for work in works}
        order: Any = {"do": "welcome"}
        try:
            while True:
                try:
                    await answers[order["do"]](order)
                except (PymeshfairError, OSError) as error:
                    place: dict[str, Any] = (
                        {"step": error.step, "parameter": error.parameter} if isinstance(error, ChoiceError) else {}
                    )
                    await self._tell("problem", message=str(error), **place)
                except (KeyError, TypeError, ValueError):
                    await self._tell("problem", message="the page asked for something that there is not; load it again")
                order = json.loads(await self._connection.recv())
        except (ConnectionClosed, ValueError):
            pass  # the page is gone, or none of ours
        finally:
            self._finish_stopped.set()
            for task in list(self._tasks):
                task.cancel()
            if not self._replaced:  # else they work for another page by now
                await self.stop({})

    async def end(self) -> None:
        """Stop what runs for the page, and tell it that another one took its place."""
        self._replaced = True
        await self.stop({})
        await self._tell("ended", message="Another page was opened for this scan; this one shows nothing new any more.")
        await self._connection.close()

    async def welcome(self, order: Mapping[str, Any]) -> None:
        """Tell what there is."""
        scan = self._scan
        recipes = [{"name": head.name, "title": head.info.title} for head in shipped_heads()]
        if self._first not in shipped_recipes():
            recipes.insert(0, {"name": self._first, "title": Path(self._first).name})
        await self._tell(
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
        await self._tell("scan", scene, **opening)

    async def recipe(self, order: Mapping[str, Any]) -> None:
        """Show a recipe."""
        name = str(order["recipe"])
        if name not in (*shipped_recipes(), self._first):
            raise ParameterError(f"there is no recipe {name!r}")
        self._recipes[name] = self._recipes.get(name) or load_recipe(name)
        await self._tell("recipe", key=name, **controls(self._recipes[name]))

    async def run(self, order: Mapping[str, Any]) -> None:
        """Run the recipe with these settings; the result comes later."""
        _, script = self._asked(order)
        scan = self._scan
        if scan.part is not None:
            script = in_mesh_units(script, scan.diagonal, scan.mean_edge)
        self._number += 1
        about: dict[str, Any] = {"run": self._number, "asked": order.get("asked")}
        await self._tell("begun", **about)
        running = await self._workshop.begin(script, self._telling(self._number))
        self._keep(self._told(running, about))

    async def _told(self, running: asyncio.Task[Result], about: Mapping[str, Any]) -> None:
        """The mesh, and when they are there its numbers."""
        try:
            numbers, scene = await asyncio.shield(running)
            await self._tell("result", scene, **about, **numbers)
            if (measuring := await self._workshop.measure(running)) is not None:
                numbers, scene = await asyncio.shield(measuring)
                await self._tell("numbers", scene, **about, **numbers)
        except (asyncio.CancelledError, Stopped) as error:
            if isinstance(error, Stopped) or running.cancelled():
                await self._tell("cancelled", **about)
        except (PymeshfairError, OSError) as error:
            await self._tell("failed", **about, message=str(error))

    async def stop(self, order: Mapping[str, Any]) -> None:
        """Stop what runs."""
        self._finish_stopped.set()
        await self._workshop.stop()

    async def save(self, order: Mapping[str, Any]) -> None:
        """Write the recipe."""
        path, overwrite = self._target(order, ".mlx"), order.get("replace") is True
        recipe, script = self._asked(order)
        if path.exists() and not overwrite:
            raise ParameterError(f"{path.name} is there already: give another name, or tick that it may be replaced")
        scan = self._scan
        script = replace(script, comment=saved_comment(recipe, scan.path.name, str(order.get("note", ""))))
        write_script(script, path, diagonal=scan.diagonal, mean_edge=scan.mean_edge, overwrite=overwrite)
        await self._tell("saved", path=str(path))

    async def finish(self, order: Mapping[str, Any]) -> None:
        """Run the recipe on the whole file, into a file."""
        path = self._target(order)
        recipe, script = self._asked(order)
        await self.stop(order)
        scan = self._scan.path
        script = replace(script, comment=saved_comment(recipe, scan.name, ""), path=None)
        job = Job(Recipe(recipe.name, script), scan, path, overwrite=order.get("replace") is True, command=tuple(sys.argv))
        stopped, tell = threading.Event(), self._telling(0)
        self._finish_stopped = stopped

        def passed_on(event: Event) -> None:
            if stopped.is_set():
                raise Stopped("stopped")
            tell(event)

        async def work() -> None:
            try:
                result = await asyncio.to_thread(run_job, job, passed_on)
            except (PymeshfairError, OSError) as error:
                await self._tell("failed", run=0, message=str(error))
            else:
                await self._tell("finished", files=[str(file) for file in (result.output, *result.side_files, result.provenance)])

        await self._tell("begun", run=0)
        self._keep(work())

    def _asked(self, order: Mapping[str, Any]) -> tuple[Recipe, Script]:
        recipe = self._recipes[str(order["recipe"])]
        return recipe, script_with(recipe.script, order["steps"])

    def _target(self, order: Mapping[str, Any], extension: str = "") -> Path:
        """A file of the folder that the command was started in."""
        name = str(order["name"]).strip()
        if not name or Path(name).name != name or name in (".", ".."):
            raise ParameterError(f"{name!r} is no name of a file: give it without a folder")
        return Path.cwd() / (name if name.casefold().endswith(extension) else name + extension)

    def _telling(self, number: int) -> Callable[[Any], None]:
        """A function that passes the events of a run on to the page."""
        loop = asyncio.get_running_loop()

        def tell(event: Any) -> None:
            document = {"event": type(event).__name__, **asdict(event)}
            loop.call_soon_threadsafe(lambda: self._keep(self._tell("event", run=number, **document)))

        return tell

    def _keep(self, work: Any) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _tell(self, what: str, scene: bytes | None = None, **more: Any) -> None:
        """Send a document and, right after it, the mesh that belongs to it."""
        async with self._sending:
            with contextlib.suppress(ConnectionClosed):
                await self._connection.send(json.dumps({"is": what, **more}))
                if scene is not None:
                    await self._connection.send(scene)
