"""What a contest is: one operation by us and by others, on subjects of several sizes."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Order: TypeAlias = str
#: "scan": meshes in the order in which subdivision leaves them, points row by row as a scanner gives them; "random": in no order.
ORDERS: tuple[Order, ...] = ("scan", "random")


class Subject(NamedTuple):
    """What an operation is applied to.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3), none for points.
        edge: the mean length of an edge, 0 for points.
        free: (n,) which vertices are to be placed, for fairing; all of them elsewhere.
    """

    vertices: Floats
    faces: Ints
    edge: float
    free: NDArray[np.bool_]


#: What is timed: takes nothing, returns what was computed.
Work: TypeAlias = Callable[[], Any]
#: Makes ready what is not timed, such as a mesh in the peer's own format; called before every round.
Preparation: TypeAlias = Callable[[Subject], Work]


@dataclass(frozen=True)
class Peer:
    """A library's way to do the same.

    Attributes:
        prepare: gives the work that is timed.
        needs: the module that must be importable.
        largest: no subject with more vertices is tried: it would take minutes.
        agrees: None if it computes something else; else the most that `Contest.result` may differ, as a share of its range.
        goal: the ratio of its time to ours that was asked for; None if none was.
    """

    prepare: Preparation
    needs: str
    largest: float = np.inf
    agrees: float | None = None
    goal: float | None = None

    def is_installed(self) -> bool:
        """Whether it can be tried here."""
        return importlib.util.find_spec(self.needs) is not None


@dataclass(frozen=True)
class Contest:
    """One operation.

    Attributes:
        name: of the operation.
        ours: gives the work that is timed.
        bound: what takes the time, in a sentence: for the page.
        peers: by name.
        subject: "mesh", "points" or "sheet"; see `subjects`.
        sizes: numbers of vertices (of free ones for a sheet).
        orders: of the vertices.
        traffic: bytes a vertex that the operation must read and write at the least; None if it does not wait for memory.
        result: what of the works' results is compared: an array.
        tiny: the size on which tests run it.
    """

    name: str
    ours: Preparation
    bound: str
    peers: Mapping[str, Peer] = field(default_factory=dict)
    subject: str = "mesh"
    sizes: tuple[int, ...] = (10_000, 100_000, 1_000_000)
    orders: tuple[Order, ...] = ORDERS
    traffic: float | None = None
    result: Callable[[Any], Floats] = np.asarray
    tiny: int = 1_000
