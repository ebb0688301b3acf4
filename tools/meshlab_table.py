"""The table of facts about MeshLab's filters, from the installed pymeshlab (for maintainers, on Linux or macOS).

Where each fact comes from:

* Python names, kinds, defaults, bounds and choices: asked of the program (`meshlab_survey`);
* whether a default or a bound depends on the mesh: asked on several meshes;
* MeshLab's own names: from the script that pymeshlab saves after it has applied a filter. Some filters kill their process, so
  each is applied in one of its own; of those that never succeed the table's names are kept, and have to agree with the Python
  names;
* menus, preconditions, changes and arity: pymeshlab tells none of them; they are kept, and were read off MeshLab's sources.
"""

from __future__ import annotations

import json
import os
import re
import signal
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from meshlab_survey import InstalledParameter, plain_value, survey_installed

from pymeshfair.meshlab.facts import python_name

TABLE = Path(__file__).parents[1] / "src/pymeshfair/meshlab/filters.json"

_KIND_OF_XML_TYPE = {
    "RichAbsPerc": "Percentage",
    "RichDynamicFloat": "Float",
    "RichMatrix44f": "Matrix",
    "RichOpenFile": "FileOpen",
    "RichPosition": "Point",
    "RichSaveFile": "FileSave",
    "RichShotf": "Shot",
}
#: filters that are never applied, since they reach out to the network
_NEVER_APPLIED = frozenset({"export_mesh_to_sketchfab"})
#: parameters whose default is the number of processors
_OF_THE_MACHINE = frozenset({"threads"})
#: whole numbers have no bounds in MeshLab; these are ours: nobody means more, and MeshLab would not come back
_MOST_ITERATIONS = 100_000
_MOST_SUBDIVISIONS = 16
_ITERATIONS = re.compile(r"iter|step(Smooth|Normal|Fit)|smooth(ing)?(Steps?|Num)|relaxStep|^steps$|MaxFunEvals", re.IGNORECASE)
_NEIGHBOURS = re.compile(r"K|KNearest|NbNeighbors")

Row = list[Any]


def generate(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table of the installed pymeshlab; what that does not tell is taken from the given table.

    Raises:
        LookupError: a filter is in neither the table nor a script that pymeshlab saves.
    """
    kept = {row[0]: row for row in table["filters"]}
    told = survey_installed()
    defaults = _defaults_on_several_meshes()
    rows = []
    for name, parameters in sorted(told.filters.items()):
        saved = _saved_script(name)
        if name not in kept:
            raise LookupError(f"filter {name!r} is new: add its menus, preconditions, changes and arity to {TABLE.name} by hand")
        _, gui_name, *masks, old_parameters = kept[name]
        written = saved[0] if saved else None
        old = {python_name(row[0]): row for row in old_parameters}
        rows.append(
            [
                name,
                gui_name if written is None else written.get("name"),
                *masks,
                [_row(name, p, saved, old.get(p.name), defaults.get((name, p.name), [])) for p in parameters],
            ]
        )
    return {"version": told.version, "filters": rows}


def _row(
    filter_name: str, told: InstalledParameter, saved: list[ET.Element], old: Row | None, seen: list[tuple[Any, float]]
) -> Row:
    """One parameter: its name in MeshLab, the class of its declaration, default, and bounds or choices."""
    written = [param for script in saved for param in script if python_name(param.get("name", "")) == told.name]
    if written:
        xml_name, xml_type = written[0].get("name", ""), written[0].get("type", "")
        kind = _KIND_OF_XML_TYPE.get(xml_type, xml_type.removeprefix("Rich"))
    elif old is not None:
        xml_name, kind = old[0], old[1]
    else:
        raise LookupError(f"parameter {told.name!r} of {filter_name!r} is new: add it to {TABLE.name} by hand")
    if kind in ("Mesh", "Shot") or xml_name in _OF_THE_MACHINE:
        return [xml_name, kind, None]
    if kind == "Percentage":
        return [xml_name, kind, _length(seen)]
    values = [value for value, _ in seen]
    row: Row = [xml_name, kind, values[0] if values and all(v == values[0] for v in values) else None]
    if kind == "Enum":
        row.append(list(told.choices))
    elif kind == "Float" and told.bounds is not None:
        fixed = (
            len({(p.get("min"), p.get("max")) for p in written}) == 1
            if len(written) > 1
            else old is not None and None not in old[3:]
        )
        row += list(told.bounds) if fixed else [None, None]
    elif kind == "Int":
        row += _int_bounds(filter_name, xml_name)
    return row


def _int_bounds(filter_name: str, xml_name: str) -> list[int | None]:
    minimum = None if "seed" in xml_name.lower() else 1 if _NEIGHBOURS.fullmatch(xml_name) else 0
    if filter_name.startswith("meshing_surface_subdivision_"):
        return [minimum, _MOST_SUBDIVISIONS]
    return [minimum, _MOST_ITERATIONS if _ITERATIONS.search(xml_name) else None]


def _length(seen: list[tuple[Any, float]]) -> str | None:
    """A default that is one length, or one part of the bounding box's diagonal, on every mesh."""
    lengths = {value for value, _ in seen}
    parts = {float(f"{100 * value / diagonal:.5g}") for value, diagonal in seen}
    if len(lengths) == 1:
        return f"{lengths.pop()}"
    return f"{parts.pop()}%" if len(parts) == 1 else None


def _defaults_on_several_meshes() -> dict[tuple[str, str], list[tuple[Any, float]]]:
    """By filter and parameter, the default on each mesh and that mesh's diagonal."""
    import pymeshlab

    found: dict[tuple[str, str], list[tuple[Any, float]]] = {}
    for build in _MESHES:
        meshes = build()
        diagonal = meshes.current_mesh().bounding_box().diagonal()
        for name in pymeshlab.filter_list():
            try:
                values = meshes.filter_parameter_values(name)
            except pymeshlab.MissingComponentException:
                continue  # three filters have no defaults where faces have no scalar
            for key, value in values.items():
                found.setdefault((name, key), []).append((plain_value(value), diagonal))
    return found


def _with_everything() -> Any:
    """A mesh with every attribute, everything selected."""
    meshes = _sample("bone.ply")
    meshes.compute_scalar_by_function_per_vertex(q="x*3+7")
    meshes.compute_scalar_by_function_per_face(q="fi*3+7")
    meshes.compute_color_by_function_per_vertex()
    meshes.compute_color_by_function_per_face()
    meshes.compute_texcoord_by_function_per_vertex()
    meshes.compute_texcoord_parametrization_triangle_trivial_per_wedge()
    meshes.compute_custom_radius_scalar_attribute_per_vertex()
    meshes.set_selection_all()
    return meshes


def _two_layers() -> Any:
    meshes = _sample("cube.obj")
    meshes.create_sphere(radius=7.3)
    meshes.compute_scalar_by_function_per_vertex(q="y*3+100")
    meshes.compute_scalar_by_function_per_face(q="fi-5")
    return meshes


def _textured() -> Any:
    return _sample("bunny10k_textured.obj")


def _cloud() -> Any:
    """A point cloud, partly selected."""
    meshes = _sample("chameleon.pts")
    meshes.compute_selection_by_condition_per_vertex(condselect="x > 0")
    return meshes


def _sample(name: str) -> Any:
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes" / name))
    return meshes


_MESHES: tuple[Callable[[], Any], ...] = (_with_everything, _two_layers, _textured, _cloud)


def _saved_script(name: str) -> list[ET.Element]:
    """What pymeshlab writes of the filter with its defaults, on each of the meshes where it succeeds."""
    if name in _NEVER_APPLIED:
        return []
    return [element for build in _MESHES if (element := _saved_on(build, name)) is not None]


def _saved_on(build: Callable[[], Any], name: str) -> ET.Element | None:
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "script.mlx"
        process = os.fork()
        if process == 0:
            os._exit(_apply_and_save(build, name, script))
        os.waitpid(process, 0)
        return ET.parse(script).getroot().find("filter") if script.exists() else None


def _apply_and_save(build: Callable[[], Any], name: str, script: Path) -> int:
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    os.chdir(script.parent)
    signal.alarm(5)
    try:
        meshes = build()
        meshes.clear_filter_script()
        meshes.apply_filter(name)
        meshes.save_filter_script(str(script))
    except Exception:
        return 1
    return 0


def _text(table: Mapping[str, Any]) -> str:
    """The table as JSON with one filter a line."""
    rows = ",\n".join(json.dumps(row, ensure_ascii=False, separators=(",", ":")) for row in table["filters"])
    return f'{{"version":{json.dumps(table["version"])},"filters":[\n{rows}\n]}}\n'


def table_text() -> str:
    """The table as it should be; prints the filters whose facts changed."""
    old = json.loads(TABLE.read_text("utf-8"))
    new = generate(old)
    before = {row[0]: row for row in old["filters"]}
    for row in new["filters"]:
        if before[row[0]] != row:
            print(f"- {json.dumps(before[row[0]])}\n+ {json.dumps(row)}")
    for name in sorted(before.keys() - {row[0] for row in new["filters"]}):
        print(f"- {name}")
    return _text(new)
