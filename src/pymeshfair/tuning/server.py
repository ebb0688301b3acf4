"""Serves the page and talks with it through one socket."""

import asyncio
import contextlib
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from ..operating_system import this_system
from ..report.page import render
from .access import Guarded
from .conversation import Conversation, Subject
from .workshop import Workshop


def application(subject: Subject, token: str, folder: Path, names: tuple[str, ...] = ()) -> Guarded:
    """The page and its socket, behind the token; `names` are host names besides ``localhost`` and addresses in numbers."""
    workshops = {False: Workshop(subject.scan.part or subject.scan.path, folder / "part")}
    if subject.scan.part is not None:
        workshops[True] = Workshop(subject.scan.path, folder / "whole")
    newest: list[Conversation] = []

    async def page(request: Request) -> HTMLResponse:
        text = render(
            "tune.html", scripts=("viewer.js", "tune.js"), sockets=True, package="pymeshfair.tuning", title=subject.scan.path.name
        )
        return HTMLResponse(text)

    async def talk(connection: WebSocket) -> None:
        await connection.accept()
        # The page that was opened last is the one that is served.
        for former in newest:
            await former.end()
        newest[:] = [Conversation(connection, subject, workshops)]
        await newest[0].held()

    @contextlib.asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        yield
        for workshop in workshops.values():
            await workshop.close()

    routes = [Route(f"/{token}/", page), WebSocketRoute(f"/{token}/socket", talk)]
    return Guarded(Starlette(routes=routes, lifespan=lifespan), token, names)


def serve(guarded: Guarded, listening: socket.socket, *, ready: Callable[[], None] = lambda: None) -> None:
    """Answer requests until Ctrl-C, or until the process is asked to end, which is done in order."""
    for name in this_system().stop_signals:
        if name != "SIGINT":
            # The server hands the signal on once it has ended; by default that would end the process on the spot.
            signal.signal(getattr(signal, name), lambda number, _: sys.exit(128 + number))
    config = uvicorn.Config(
        guarded,
        access_log=False,  # which would write the token
        log_level="warning",
        ws="websockets-sansio",
        ws_max_size=1 << 20,
        lifespan="on",
        timeout_graceful_shutdown=2,
    )
    server = uvicorn.Server(config)

    async def main() -> None:
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        while not (server.started or serving.done()):
            await asyncio.sleep(0.01)
        if server.started:
            ready()
        await serving

    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(main())


def listening_socket(host: str, port: int) -> socket.socket:
    """A socket of this machine's; port 0 takes one that is free."""
    return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
