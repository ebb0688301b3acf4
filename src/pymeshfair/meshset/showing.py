"""Shows the layers of a mesh set as text for terminals and as HTML for notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any


def layer_rows(meshes: Any) -> list[tuple[str, str, str]]:
    """(number, name, size) of every layer of a mesh set; the number of the current layer ends with ``*``."""
    current = meshes.current_mesh_id() if meshes.mesh_number() else -1
    rows = []
    for mesh in meshes:
        counts = ((mesh.vertex_number(), "vertices"), (mesh.face_number(), "faces"), (mesh.edge_number(), "edges"))
        size = ", ".join(f"{count:,} {what}" for count, what in counts if count or what == "vertices")
        rows.append((f"{mesh.id()}{'*' if mesh.id() == current else ''}", mesh.label(), size))
    return rows


def layers_text(meshes: Any) -> str:
    """One line per layer."""
    rows = layer_rows(meshes)
    return "\n".join([f"MeshSet of {_layer_count(rows)}", *(f"  {number:<4} {name}: {size}" for number, name, size in rows)])


def layers_line(meshes: Any) -> str:
    """The number of layers and the current one, for ``repr``."""
    rows = layer_rows(meshes)
    current = [f", current {number.rstrip('*')} {name!r}: {size}" for number, name, size in rows if number.endswith("*")]
    return f"<{type(meshes).__name__} of {_layer_count(rows)}{''.join(current)}>"


def _layer_count(rows: Sequence[Any]) -> str:
    return f"{len(rows)} {'layer' if len(rows) == 1 else 'layers'}"


def layers_table(meshes: Any) -> str:
    """The layers as a table of HTML; the current one is bold."""
    lines = ["<table>", "<tr><th>layer</th><th>name</th><th>size</th></tr>"]
    for row in layer_rows(meshes):
        cells = (f"<b>{escape(cell)}</b>" if row[0].endswith("*") else escape(cell) for cell in row)
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return "\n".join([*lines, "</table>"])
