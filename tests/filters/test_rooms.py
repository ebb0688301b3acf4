"""The rooms of the mathematics, packages or single modules: foundation below families, imports downwards only."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

FILTERS = Path(__file__).parents[2] / "filters"
#: the foundation from the ground up: a package imports those before it
FOUNDATION = (
    "checks",
    "libraries",
    "compilation",
    "execution",
    "mesh",
    "topology",
    "geometry",
    "neighbours",
    "robust",
    "quadrics",
    "operators",
    "linear_solvers",
    "evidence",
)
#: the families, and which others each of them may import besides the foundation
FAMILIES = {
    "diffusion": set(),
    "denoising": {"diffusion", "inspection"},
    "fairing": {"denoising", "diffusion", "inspection"},
    "holes": {"fairing"},
    "curves": {"diffusion"},
    "spectral": set(),
    "outliers": set(),
    "inspection": set(),
    "choosing": {"diffusion", "denoising", "fairing", "spectral"},
    "traits": {"denoising", "diffusion"},
}
MODULES = sorted(path for path in FILTERS.rglob("*.py") if path != FILTERS / "__init__.py")


def room(path: Path) -> str:
    """The room that a module belongs to: a package of `filters`, or the module itself."""
    return path.relative_to(FILTERS).parts[0].removesuffix(".py")


def imported(path: Path) -> list[tuple[str, str]]:
    """The other rooms that a module imports from, and the module within each of them, '' for the package itself."""
    depth = len(path.relative_to(FILTERS).parts)
    found = []
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == depth:
            names = [node.module] if node.module else [alias.name for alias in node.names]
            for name in names:
                other, _, inside = name.partition(".")
                found.append((other, inside))
    return found


def test_every_room_has_a_place() -> None:
    """A new room is placed before it is used, and none that is gone is named."""
    assert {room(path) for path in MODULES} == set(FOUNDATION) | set(FAMILIES)


def test_rooms_import_downwards() -> None:
    """The foundation imports what lies below, a family the foundation and the families that it is built on."""
    wrong = []
    for path in MODULES:
        own = room(path)
        allowed = set(FOUNDATION[: FOUNDATION.index(own)]) if own in FOUNDATION else set(FOUNDATION) | FAMILIES[own]
        wrong += [f"{path}: {other}" for other, _ in imported(path) if other not in allowed]
    assert not wrong


#: libraries that take long to import, so that nothing imports them but when they are needed
SLOW = {"numba", "scipy", "igl", "robust_laplacian", "threadpoolctl"}


def test_slow_libraries_are_imported_when_they_are_used() -> None:
    """Kernels are marked by `compilation`, and libraries come from `libraries`: importing a filter costs next to nothing."""
    wrong = []
    for path in MODULES:
        tree = ast.parse(path.read_text("utf-8"))
        named = {a.name for node in tree.body if isinstance(node, ast.Import) for a in node.names}
        named |= {node.module or "" for node in tree.body if isinstance(node, ast.ImportFrom) and not node.level}
        if room(path) not in ("libraries", "compilation"):
            wrong += [f"{path}: {name}" for name in named if name.partition(".")[0] in SLOW]
    assert not wrong


def test_the_foundation_is_entered_by_its_front_door() -> None:
    """What others need of a foundation package is imported from the package, so that its modules may move."""
    assert not [
        f"{path}: {other}.{inside}" for path in MODULES for other, inside in imported(path) if other in FOUNDATION and inside
    ]


@pytest.mark.parametrize("name", FOUNDATION + tuple(FAMILIES))
def test_a_room_says_what_it_offers(name: str) -> None:
    """Every room has an `__all__`, in which each name exists and none stands twice."""
    package = importlib.import_module(f"pymeshfair.filters.{name}")
    assert len(package.__all__) == len(set(package.__all__)) > 0
    assert not [offered for offered in package.__all__ if not hasattr(package, offered)]
