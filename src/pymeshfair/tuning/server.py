"""Serves the page and talks with it through one socket, behind a token.

Access is by the token, from a page of the server itself, under a name of this machine.
"""

import contextlib
import hmac
import ipaddress
import os
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable
from html import escape
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from ..operating_system import this_system
from ..report.page import render
from .conversation import Conversation, Subject
from .workshop import Workshop

#: of every answer: browsers keep nothing and tell other sites nothing; a notebook, which has the token, may frame the page
_HEADERS = [
    (b"cache-control", b"no-store"),
    (b"referrer-policy", b"no-referrer"),
    (b"x-content-type-options", b"nosniff"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cross-origin-opener-policy", b"same-origin"),
]


def redirecting_file(address: str, folder: Path) -> Path:
    """A file that leads a browser to an address, and that this user alone can read.

    The address holds the token, and every user of the machine can read the browser's command line.
    """
    path = folder / "open.html"
    where = escape(address)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
        file.write(
            f'<!DOCTYPE html>\n<meta http-equiv="refresh" content="0; url={where}">\n<a href="{where}">pymeshfair tune</a>\n'
        )
    return path


class Guarded:
    """An application behind a token.

    A request is answered with 403 unless its path begins with the token; the ``Host`` header is an address in numbers,
    ``localhost`` or the name that was asked for, so that no other site's name leads here; and the ``Origin`` header, without
    which no browser opens a socket, is that host itself.

    Args:
        application: to be guarded.
        token: the first part of every path.
        names: host names besides ``localhost`` and addresses in numbers.
    """

    def __init__(self, application: ASGIApp, token: str, names: tuple[str, ...] = ()) -> None:
        self._application = application
        self._start = f"/{token}/".encode()
        self._names = {"localhost", *(name.casefold() for name in names)}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request of ASGI."""
        if scope["type"] in ("http", "websocket") and not self.allows(scope):
            await _refuse(scope, receive, send)
        else:
            await self._application(scope, receive, _with_headers(send) if scope["type"] == "http" else send)

    def allows(self, scope: Scope) -> bool:
        """Whether token, host and origin are right."""
        path = str(scope["path"]).encode("utf-8", "replace")
        if not hmac.compare_digest(path[: len(self._start)], self._start):
            return False
        headers = [(name.lower(), value.decode("latin-1")) for name, value in scope["headers"]]
        hosts = [value for name, value in headers if name == b"host"]
        origins = [value for name, value in headers if name == b"origin"]
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            return False
        if scope["type"] == "websocket" and not origins:
            return False
        return all(origin == f"http://{hosts[0]}" for origin in origins)

    def _is_ours(self, host: str) -> bool:
        name = host.rsplit(":", 1)[0] if not host.endswith("]") else host
        if name.casefold() in self._names:
            return True
        try:
            ipaddress.ip_address(name.removeprefix("[").removesuffix("]"))
        except ValueError:
            return False
        return True


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})  # before it is accepted, that is an answer with 403
        return
    await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain"), *_HEADERS]})
    await send({"type": "http.response.body", "body": b"403: this page needs the address that pymeshfair tune printed\n"})


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            message = {**message, "headers": [*message.get("headers", ()), *_HEADERS]}
        await send(message)

    return sending


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
        loop="asyncio",  # wherever another one is installed, too
        timeout_graceful_shutdown=2,
    )
    with contextlib.suppress(KeyboardInterrupt):
        _Server(config, ready).run(sockets=[listening])


class _Server(uvicorn.Server):
    """A server that says when it answers."""

    def __init__(self, config: uvicorn.Config, ready: Callable[[], None]) -> None:
        super().__init__(config)
        self._ready = ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._ready()


def listening_socket(host: str, port: int) -> socket.socket:
    """A socket of this machine's; port 0 takes one that is free."""
    return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
