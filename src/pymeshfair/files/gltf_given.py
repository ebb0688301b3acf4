"""What a glTF document holds of a mesh, what MeshLab does not read of it, and the document that MeshLab is given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .gltf_document import READ, Mesh


def counts_of(document: Mapping[str, Any], meshes: Sequence[Mesh]) -> tuple[int | None, int | None]:
    """How many vertices and faces all of its nodes have."""
    by_mesh = []
    position = 0
    for mesh in document.get("meshes", ()):
        own = meshes[position : position + len(mesh["primitives"])]
        position += len(own)
        by_mesh.append(own)
    level = [n for scene in document.get("scenes", ()) for n in scene.get("nodes", ())]
    vertices = faces = 0
    while level:
        for n in level:
            own = by_mesh[document["nodes"][n]["mesh"]] if "mesh" in document["nodes"][n] else []
            vertices += sum(m.vertices for m in own)
            faces += sum(m.faces for m in own)
        level = [c for n in level for c in document["nodes"][n].get("children", ())]
    return vertices, faces


def losses_of(document: Mapping[str, Any]) -> tuple[str, ...]:
    """What it has that MeshLab does not read, in words."""
    lost = [name for name in ("animations", "skins", "cameras") if document.get(name)]
    primitives = [p for mesh in document.get("meshes", ()) for p in mesh["primitives"]]
    lost += [f"attribute {name}" for name in sorted({n for p in primitives for n in p["attributes"]} - set(READ))]
    lost += ["morph targets"] if any(p.get("targets") for p in primitives) else []
    named = [n for n in ("meshes", "nodes", "materials") if any("name" in x for x in document.get(n, ()))]
    lost += [f"names of {', '.join(named)}"] if named else []
    parts = [document, *(x for v in document.values() if isinstance(v, list) for x in v if isinstance(x, dict))]
    lost += ["extras"] if any("extras" in x for x in parts) else []
    lost += [f"extension {name}" for name in document.get("extensionsUsed", ())]
    maps = {k for m in document.get("materials", ()) for k in m if k.endswith("Texture")}
    maps |= {
        k for m in document.get("materials", ()) for k in m.get("pbrMetallicRoughness", {}) if k == "metallicRoughnessTexture"
    }
    return tuple(lost + sorted(maps))


_KEPT = {
    "asset": ("version",),
    "scenes": ("nodes",),
    "nodes": ("children", "mesh", "matrix", "rotation", "scale", "translation"),
    "bufferViews": ("buffer", "byteOffset", "byteLength", "byteStride", "target"),
    "accessors": ("bufferView", "byteOffset", "componentType", "count", "type", "normalized", "min", "max"),
    "textures": ("source",),
}


def pruned(document: Mapping[str, Any], images: Sequence[str | None]) -> dict[str, Any]:
    """The document with nothing else than what MeshLab reads, its images under the names that they are given by."""
    kept: dict[str, Any] = {"asset": {"version": "2.0"}}
    for name, keys in _KEPT.items():
        if name != "asset" and name in document:
            kept[name] = [{k: part[k] for k in keys if k in part} for part in document[name]]
    kept["images"] = [{"uri": name} for name in images]
    kept["materials"] = [_material(m) for m in document.get("materials", ())]
    kept["meshes"] = [{"primitives": [_pruned_primitive(p) for p in m["primitives"]]} for m in document.get("meshes", ())]
    return {name: part for name, part in kept.items() if part}


def _material(material: Mapping[str, Any]) -> dict[str, Any]:
    surface = material.get("pbrMetallicRoughness", {})
    kept = {k: surface[k] for k in ("baseColorFactor",) if k in surface}
    if "baseColorTexture" in surface:
        kept["baseColorTexture"] = {"index": surface["baseColorTexture"]["index"]}
    return {"pbrMetallicRoughness": kept}


def _pruned_primitive(p: Mapping[str, Any]) -> dict[str, Any]:
    kept = {k: p[k] for k in ("indices", "mode", "material") if k in p}
    return kept | {"attributes": {name: k for name, k in p["attributes"].items() if name in READ}}
