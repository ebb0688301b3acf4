"""The sockets on which processes wait for connections, for the tests."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
from pathlib import Path

from tests.tiles.tiling import children_of

#: a program that connects to the address that is its argument, as another user if it may become one
_CONNECTS = """
import encodings.idna, os, socket, sys  # before it cannot read them any more
host, port = sys.argv[1].rsplit(" ", 1)
if os.getuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
socket.create_connection((host, int(port)), timeout=5).close()
"""


def listening(process: int) -> set[str]:
    """Where a process and all that it has started wait for connections: an address and a port each, or a path."""
    inodes = set()
    for pid in (process, *children_of(process)):
        for descriptor in Path(f"/proc/{pid}/fd").glob("*"):
            with contextlib.suppress(OSError):  # closed meanwhile
                inodes.add(descriptor.readlink().name)
    inodes = {name.removeprefix("socket:[").rstrip("]") for name in inodes if name.startswith("socket:[")}
    found = set()
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            words = line.split()
            if words[9] in inodes and words[3] in ("0A", "07"):  # waits for connections; for packets
                found.add(_address(words[1]))
    for line in Path("/proc/net/unix").read_text().splitlines()[1:]:
        words = line.split()
        if words[6] in inodes and int(words[3], 16) & 0x10000:
            found.add(words[7] if len(words) > 7 else "a Unix socket without a path")
    return found


def _address(text: str) -> str:
    """The address and the port that the system writes in hexadecimal, four bytes at a time in its own order."""
    host, port = text.split(":")
    packed = b"".join(bytes.fromhex(host[k : k + 8])[:: -1 if sys.byteorder == "little" else 1] for k in range(0, len(host), 8))
    return f"{socket.inet_ntop(socket.AF_INET if len(packed) == 4 else socket.AF_INET6, packed)} {int(port, 16)}"


def lets_in(address: str) -> bool:
    """Whether another user can connect there; this user where this process may not become another."""
    return subprocess.run([sys.executable, "-c", _CONNECTS, address], capture_output=True).returncode == 0
