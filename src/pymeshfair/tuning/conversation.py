"""The messages between page and server over one socket: JSON documents, and meshes as bytes."""

import asyncio
import contextlib
import json
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect

from ..errors import ParameterError, PymeshfairError
from ..recipe import Recipe, load_recipe, shipped_heads
from ..running.job import Event, Job
from ..running.supervise import run_job
from ..scripts.script import Script
from ..scripts.write import write_script
from .bench import Result, Stopped
from .controls import ChoiceError, choices_of, controls, in_mesh_units, saved_comment, script_with
from .scan import Scan, cut_out
from .workshop import Workshop


@dataclass(frozen=True)
class Subject:
    """The subject of a page."""

    scan: Scan
    recipe: str  # the name or path of the recipe that is shown first
    folder: Path  # for recipes and results


class Conversation:
    """One page."""

    def __init__(self, connection: WebSocket, subject: Subject, workshops: dict[bool, Workshop]) -> None:
        """Talk through an accepted socket; there is a workshop for the scan, and one for the whole of a large one."""
        self._connection = connection
        self._subject = subject
        self._workshops = workshops
        self._recipes: dict[str, Recipe] = {}
        self._number = 0
        self._sending = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()
        self._finish_stopped = threading.Event()  # stops a run of the file into a file at its next sign of life
        self._opened: set[bool] = set()
        self._replaced = False

    async def held(self) -> None:
        """Answer the page until it is closed."""
        answers = {
            "welcome": self._welcome,
            "recipe": self._choose,
            "run": self._run,
            "stop": self._stop,
            "save": self._save,
            "finish": self._finish,
            "overview": self._overview,
            "part": self._part,
        }
        order: Any = {"do": "welcome"}
        try:
            while True:
                try:
                    await answers[order["do"]](order)
                except ChoiceError as error:
                    await self._tell("problem", message=str(error), step=error.step, parameter=error.parameter)
                except (PymeshfairError, OSError) as error:
                    await self._tell("problem", message=str(error))
                except (KeyError, TypeError, ValueError):
                    await self._tell("problem", message="the page asked for something that there is not; load it again")
                order = json.loads(await self._connection.receive_text())
        except (WebSocketDisconnect, RuntimeError, json.JSONDecodeError):
            pass  # the page is gone, or none of ours
        finally:
            await self._leave()

    async def end(self) -> None:
        """Stop what runs for the page, and tell it that another one took its place."""
        self._replaced = True
        await self._stop({})
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._tell("ended", message="Another page was opened for this scan; this one shows nothing new any more.")
            await self._connection.close()

    async def _leave(self) -> None:
        self._finish_stopped.set()
        for task in list(self._tasks):
            task.cancel()
        if not self._replaced:  # else they work for another page by now
            await self._stop({})

    # ------------------------------------------------------------------------------------------------------------- answers

    async def _welcome(self, order: Mapping[str, Any]) -> None:
        scan = self._subject.scan
        heads = [{"name": head.name, "title": head.info.title} for head in shipped_heads()]
        if self._subject.recipe not in {head["name"] for head in heads}:
            heads.insert(0, {"name": self._subject.recipe, "title": Path(self._subject.recipe).name})
        await self._tell(
            "welcome",
            scan=scan.path.name,
            vertices=scan.vertices,
            has_part=scan.part is not None,
            diagonal=scan.diagonal,
            mean_edge=scan.mean_edge,
            recipes=heads,
            chosen=self._subject.recipe,
            folder=str(self._subject.folder),
            warnings=list(scan.warnings),
        )
        await self._show_recipe(self._subject.recipe)
        await self._open(False)

    async def _open(self, whole: bool) -> None:
        """Show the scan, or the whole of it."""
        await self._tell("opening", whole=whole)
        opening, scene = await self._workshops[whole].open()
        self._opened.add(whole)
        await self._tell("scan", scene, whole=whole, **opening)

    async def _overview(self, order: Mapping[str, Any]) -> None:
        """Show the whole of a large scan, so that a part of it can be chosen."""
        await self._stop(order)
        await self._open(True)

    async def _part(self, order: Mapping[str, Any]) -> None:
        """Take another part of a large scan."""
        x, y, z = map(float, order["place"])
        radius = None if order.get("radius") is None else float(order["radius"])
        scan = self._subject.scan
        if scan.part is None or not np.isfinite([x, y, z, radius or 0.0]).all():
            raise ParameterError("this scan has no such part")
        await self._stop(order)
        part = Path(tempfile.mkdtemp(prefix="part-", dir=scan.part.parent)) / "part.ply"
        await asyncio.to_thread(cut_out, scan.path, part, (x, y, z), radius)
        await self._workshops[False].close()
        self._workshops[False] = Workshop(part, part.with_suffix(""))
        await self._open(False)

    async def _show_recipe(self, name: str) -> None:
        if name not in self._recipes:
            names = {head.name for head in shipped_heads()} | {self._subject.recipe}
            if name not in names:
                raise ParameterError(f"there is no recipe {name!r}")
            self._recipes[name] = load_recipe(name)
        await self._tell("recipe", key=name, **controls(self._recipes[name]))

    async def _choose(self, order: Mapping[str, Any]) -> None:
        await self._show_recipe(str(order["recipe"]))

    async def _run(self, order: Mapping[str, Any]) -> None:
        _, script = self._asked(order)
        whole = order.get("whole") is True and True in self._workshops
        for other, workshop in self._workshops.items():
            if other != whole:
                await workshop.stop()
        if whole not in self._opened:
            await self._open(whole)
        scan = self._subject.scan
        if scan.part is not None and not whole:
            script = in_mesh_units(script, scan.diagonal, scan.mean_edge)
        self._number += 1
        number = self._number
        await self._tell("begun", run=number, asked=order.get("asked"))
        workshop = self._workshops[whole]
        running = await workshop.begin(number, script, self._telling(number))
        self._keep(self._told(workshop, number, order.get("asked"), running))

    async def _told(self, workshop: Workshop, number: int, asked: Any, running: asyncio.Task[Result]) -> None:
        """The mesh, and when they are there its numbers."""
        try:
            numbers, scene = await asyncio.shield(running)
            await self._tell("result", scene, run=number, asked=asked, **numbers)
            if (measuring := await workshop.measure(number)) is not None:
                numbers, scene = await asyncio.shield(measuring)
                await self._tell("numbers", scene, run=number, asked=asked, **numbers)
        except (asyncio.CancelledError, Stopped) as error:
            if isinstance(error, Stopped) or running.cancelled():
                await self._tell("cancelled", run=number, asked=asked)
        except (PymeshfairError, OSError) as error:
            await self._tell("failed", run=number, asked=asked, message=str(error))

    async def _stop(self, order: Mapping[str, Any]) -> None:
        self._finish_stopped.set()
        for workshop in self._workshops.values():
            await workshop.stop()

    async def _save(self, order: Mapping[str, Any]) -> None:
        path, overwrite = self._target(order, ".mlx"), order.get("replace") is True
        recipe, script = self._asked(order)
        if path.exists() and not overwrite:
            raise ParameterError(f"{path.name} is there already: give another name, or tick that it may be replaced")
        scan = self._subject.scan
        script = replace(script, comment=saved_comment(recipe, scan.path.name, str(order.get("note", ""))))
        write_script(script, path, diagonal=scan.diagonal, mean_edge=scan.mean_edge, overwrite=overwrite)
        await self._tell("saved", path=str(path))

    async def _finish(self, order: Mapping[str, Any]) -> None:
        path = self._target(order, "")
        recipe, script = self._asked(order)
        await self._stop(order)
        scan = self._subject.scan.path
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

    # ------------------------------------------------------------------------------------------------------------- details

    def _asked(self, order: Mapping[str, Any]) -> tuple[Recipe, Script]:
        recipe = self._recipes[str(order["recipe"])]
        return recipe, script_with(recipe.script, choices_of(order["steps"]))

    def _target(self, order: Mapping[str, Any], extension: str) -> Path:
        """A file of the folder that the command was started in."""
        name = str(order["name"]).strip()
        if not name or Path(name).name != name or name in (".", ".."):
            raise ParameterError(f"{name!r} is no name of a file: give it without a folder")
        if extension and Path(name).suffix.casefold() != extension:
            name += extension
        return self._subject.folder / name

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
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await self._connection.send_text(json.dumps({"is": what, **more}))
                if scene is not None:
                    await self._connection.send_bytes(scene)
