"""Every recipe on ten scans or nine others, as they are and with noise of 0.3 edges: figures, pictures, what is left unsaid.

    python benchmarks/recipes_on_scans.py FOLDER --scans FOLDER [--second] [--only text,text] [--recipes text,text] [--table]
        [--picture PNG]

FOLDER gets the inputs, a line of JSON for each run in `runs.jsonl`, and sheets of pictures for each input; what is there is not
run again. --scans has rabbit.obj, angel.obj, iron.ply, and nicolo_n2_truth.ply; the others are samples of pymeshlab, a gear whose
STL file splits its points, and a terrestrial scan: ground to 60 m from a tripod, a wall, a pole, a wire, 1 % of far points.
--second takes a second set, which no recipe and no warning was made by: julius, fertility, child, fandisk and a Kinect's cone in
--scans, an airplane, a cow and a cloud of pymeshlab, and blobs segmented in a volume, whose surface has the steps of its voxels.
--table prints a row for each recipe of what was run, and every run that has a finding.

A finding is what a run should have said and has not, from the truth: relief that went, noise that stays after a recipe that
removes noise, a surface that is farther from the truth than before. What adds surface is judged by the 95 % nearest vertices.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import igl
import numpy as np
import pymeshlab
from denoising_metrics import Floats, Ints
from denoising_pairs import SAMPLES, along_normals, gear

from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_write import write_ply
from pymeshfair.filters.denoising import Scan
from pymeshfair.filters.diffusion import relief_lost
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.looking.picture import Appearance, draw_meshes
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import load_recipe, shipped_heads

LEVEL = 0.3
#: what recipes need that no scan has: a region, by its centre and its size
SETTINGS = {"fair_selection": "Conditional Vertex Selection.condSelect=(x-{0})^2+(y-{1})^2+(z-{2})^2<{3}^2"}
#: relief that may go unsaid, and noise in mean edges
RELIEF, NOISE = 0.1, 0.1


def terrestrial(noise: float) -> Floats:
    """The points of a scan from a tripod: ever sparser ground, a wall, a pole and a wire, with noise in metres."""
    rng = np.random.default_rng(5)
    reach, around = (g.ravel() for g in np.meshgrid(np.geomspace(1.5, 60.0, 176), np.radians(np.arange(0.0, 360.0, 1.2))))
    ground = np.stack([reach * np.cos(around), reach * np.sin(around), np.zeros(reach.size)], axis=1)
    ground[:, 2] = 0.3 * np.sin(ground[:, 0] / 7.0) * np.cos(ground[:, 1] / 9.0)
    y, z = np.meshgrid(np.arange(-5.0, 5.0, 0.08), np.arange(0.0, 4.0, 0.08), indexing="ij")
    wall = np.stack([np.full(y.size, 12.0), y.ravel(), z.ravel()], axis=1)
    turn, up = np.meshgrid(np.linspace(0.0, np.pi, 12), np.arange(0.0, 6.0, 0.04), indexing="ij")
    pole = np.stack([-6.0 + 0.1 * np.cos(turn.ravel()), 5.0 + 0.1 * np.sin(turn.ravel()), up.ravel()], axis=1)
    along = np.linspace(0.0, 1.0, 600)
    wire = np.stack([-6.0 + 18.0 * along, 5.0 - 3.0 * along, 6.0 - 6.0 * along * (1.0 - along)], axis=1)
    points = np.concatenate([ground, wall, pole, wire])
    points += rng.normal(scale=noise, size=points.shape)
    far = rng.uniform(points.min(axis=0) - 5.0, points.max(axis=0) + 5.0, (len(points) // 100, 3))
    return np.concatenate([points, far])


def write_inputs(folder: Path, scans: Path) -> None:
    """All twenty, each with its truth beside it."""
    places: dict[str, Path] = {name: next(scans.rglob(f"{name}.*")) for name in ("rabbit", "angel", "iron", "nicolo_n2_truth")}
    places |= {name: SAMPLES / name for name in ("bunny.obj", "bone.ply", "rangemaps/face000.ply", "bunny10k_textured.obj")}
    names = ("rabbit", "angel", "iron", "nicolo", "bunny", "bone", "face", "textured")
    for name, path in zip(names, places.values(), strict=True):
        mesh = read_file(path).mesh
        kind = ".obj" if name == "textured" else ".ply"
        for level, end in ((0.0, ""), (LEVEL, "_noisy")):
            target, moved = folder / f"{name}{end}{kind}", noisy(mesh.vertices, mesh.faces, level)
            if name == "textured":
                _textured(path, target, moved)
            else:
                _write(target, moved, mesh.faces)
    points, faces = gear()
    for level, end in ((0.0, ""), (LEVEL, "_noisy")):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(noisy(points, faces, level), faces))
        meshes.save_current_mesh(str(folder / f"gear{end}.stl"))
        _write(folder / f"terrestrial{end}.ply", terrestrial(0.02 * bool(level)), np.empty((0, 3), np.int32))


def write_second_inputs(folder: Path, scans: Path) -> None:
    """Those of the second set; the cloud as it is alone."""
    pairs = {
        "julius": "julius_n2_truth",
        "fertility": "fertility_n3_truth",
        "child": "child_n3_truth",
        "fandisk": "fandisk_n3_truth",
    }
    places = {name: next(scans.rglob(f"{file}.ply")) for name, file in (pairs | {"kinect": "kinect_cone_noisy"}).items()}
    places |= {name: SAMPLES / f"{name}.obj" for name in ("airplane", "cow")}
    meshes = {name: (mesh.vertices, mesh.faces) for name, mesh in ((name, read_file(path).mesh) for name, path in places.items())}
    for name, (points, faces) in (meshes | {"voxels": voxels()}).items():
        for level, end in ((0.0, ""), (LEVEL, "_noisy")):
            _write(folder / f"{name}{end}.ply", noisy(points, faces, level), faces)
    cloud = pymeshlab.MeshSet()
    cloud.load_new_mesh(str(SAMPLES / "chameleon.pts"))
    cloud.save_current_mesh(str(folder / "chameleon.ply"))


def voxels(n: int = 56) -> tuple[Floats, Ints]:
    """The border of what is segmented in a volume of n^3 voxels, by marching cubes: steps of a voxel all over it."""
    axis = np.linspace(-1.0, 1.0, n)
    z, y, x = (a.ravel() for a in np.meshgrid(axis, axis, axis, indexing="ij"))
    centres = ((-0.4, 0.1, 0.0, 0.45), (0.3, 0.2, 0.15, 0.5), (0.1, -0.4, -0.2, 0.35))
    inside = np.sum(
        [np.exp(-4.0 * (((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / r**2 - 1.0)) for a, b, c, r in centres], axis=0
    )
    vertices, faces, *_ = igl.marching_cubes(np.where(inside > 1.0, -1.0, 1.0), np.column_stack([x, y, z]), n, n, n, 0.0)
    return vertices, np.asarray(faces, dtype=np.int32)


def noisy(points: Floats, faces: Ints, level: float) -> Floats:
    """Vertices with noise along their normals, in mean edges."""
    return along_normals(level)(points, faces, np.random.default_rng(3)) if level else points


def _write(path: Path, points: Floats, faces: Ints) -> None:
    with path.open("wb") as file:
        write_ply(MeshData(vertices=points, faces=faces), file)


def _textured(source: Path, target: Path, points: Floats) -> None:
    rows = iter(points.tolist())
    lines = source.read_text().splitlines()
    moved = ["v {} {} {}".format(*next(rows)) if line.startswith("v ") else line for line in lines]
    target.write_text("\n".join(moved) + "\n")
    for path in (source.with_suffix(".mtl"), *source.parent.glob("*.png")):
        shutil.copy(path, target.parent)


def recipes_of(kind: str) -> list[str]:
    """The recipes for clouds or for meshes that are not superseded; of those that need two layers or curves there are none."""
    found = (head.name for head in shipped_heads() if not head.info.superseded)
    return [n for n in found if kind in {c.text for c in load_recipe(n).info.conditions} and n != "blend_parts"]


def run(recipe: str, scan: Path, target: Path) -> dict[str, Any]:
    """The document of a run, its exit code and its messages."""
    command = [sys.executable, "-m", "pymeshfair", "run", recipe, str(scan), "-o", str(target), "--overwrite", "--json"]
    if recipe in SETTINGS:
        mesh = read_file(scan).mesh
        command += [
            "--set",
            SETTINGS[recipe].format(*mesh.vertices[mesh.faces[0, 0]], 8.0 * mean_edge_length(mesh.vertices, mesh.faces)),
        ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900)
    document = json.loads(done.stdout) if done.stdout.startswith("{") else {}
    said = done.stderr.strip().splitlines()
    warnings = [line.removeprefix("warning: ") for line in said if line.startswith("warning: ")]
    return {"exit": done.returncode, "messages": said[-1:], "warnings": warnings, **document}


def target_of(scan: Path, recipe: str) -> Path:
    """The file of a result."""
    return scan.with_name(f"{scan.stem}+{recipe}{'.obj' if scan.suffix == '.obj' else '.ply'}")


def row_of(recipe: str, scan: Path) -> dict[str, Any]:
    """What is told of a run, and what is true."""
    target = target_of(scan, recipe)
    document = run(recipe, scan, target)
    change, warnings = document.get("change") or {}, document.get("warnings", [])
    row: dict[str, Any] = {"scan": scan.stem, "recipe": recipe, "exit": document["exit"], "warnings": warnings}
    if document["exit"]:
        return row | {"error": (document.get("error") or {}).get("message") or " ".join(document["messages"])}
    moved = change.get("moved") or {}
    row |= {
        "moved": [moved.get("mean_edges"), moved.get("edges")],
        "removed": [change["removed"]["vertices"], change["removed"]["share"]],
        "added": change["added"]["share"],
        "relief told": change["relief_lost"],
        "sharp kept": change["sharp_kept"],
        "notes": [text for step in document["steps"] for text in step["messages"]],
    }
    truth, before, after = (read_file(p).mesh for p in (scan.with_name(scan.name.replace("_noisy", "")), scan, target))
    if not len(after.faces) or not len(truth.faces):
        return row
    edge = mean_edge_length(truth.vertices, truth.faces)
    row["noise"] = [Scan.of(mesh.vertices, mesh.faces).noise.deviation for mesh in (before, after)]
    was_there = after.faces[(after.faces < len(before.vertices)).all(axis=1)]  # what fills holes is appended
    judged = (before, MeshData(vertices=after.vertices, faces=was_there))
    row["distance"] = [distance(mesh, truth) / edge for mesh in judged]
    if len(after.vertices) == len(truth.vertices) and np.array_equal(after.faces, truth.faces):
        level = row["noise"][0] if "_noisy" not in scan.stem else 0.0
        lost = relief_lost(truth.vertices, after.vertices, truth.faces, noise=level)
        row["relief"] = None if lost is None else lost.share
    return row


def distance(mesh: MeshData, truth: MeshData) -> float:
    """The root mean square distance of the 95 % nearest vertices from a surface."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(truth.vertices, truth.faces))
    meshes.add_mesh(pymeshlab.Mesh(mesh.vertices[np.unique(mesh.faces)]))
    meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(measuremesh=1, refmesh=0, signeddist=False)
    away = np.sort(np.abs(meshes.mesh(1).vertex_scalar_array()))
    return float(np.sqrt(np.mean(away[: int(np.ceil(0.95 * len(away)))] ** 2)))


def findings(row: dict[str, Any]) -> Iterator[str]:
    """What should have been said and was not."""
    removes_noise = load_recipe(row["recipe"]).info.task in ("clean", "denoise", "smooth")
    if row["exit"] or row["warnings"] or not removes_noise:
        return
    if (row.get("relief") or 0.0) > RELIEF:
        yield f"{row['relief']:.0%} of the relief went"
    if "distance" in row and not row["added"] and row["distance"][1] > row["distance"][0] + 0.05:
        yield f"{row['distance'][1]:.2f} edges from the truth, before {row['distance'][0]:.2f}"
    if "noise" in row and "_noisy" in row["scan"] and row["noise"][1] > NOISE:
        yield f"noise of {row['noise'][1]:.2f} stays"


def removing_noise() -> list[str]:
    """The recipes for meshes that remove noise."""
    return [name for name in recipes_of("mesh") if load_recipe(name).info.task in ("clean", "denoise", "smooth")]


def tables(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    """What recipes that remove noise do, a column for each scan, and what became of all runs of each recipe."""
    found = {(row["scan"], row["recipe"]): row for row in rows}
    scans = [
        scan
        for scan in dict.fromkeys(row["scan"].removesuffix("_noisy") for row in rows)
        if scan not in ("terrestrial", "chameleon")
    ]
    others = [
        name for name in recipes_of("mesh") if load_recipe(name).info.task in ("repair", "prepare", "remesh", "change the shape")
    ]

    def cell(scan: str, name: str, words: Callable[[dict[str, Any]], str]) -> str:
        row = found.get((scan, name))
        if row is None or row["exit"]:
            return "-"
        return f"({words(row)})" if row["warnings"] else words(row)

    def relief(row: dict[str, Any]) -> str:
        lost = row["relief told"] if row["relief told"] is not None else row.get("relief")
        return "0" if not row["moved"][1] else "?" if lost is None else f"{100.0 * lost:.0f}"

    def kept(row: dict[str, Any]) -> str:
        more = row["added"] - row["removed"][1]
        return f"{row['distance'][1]:.2f}" + (f" +{more:.0%}" if more > 0.005 else "")

    for title, end, words, names in (
        (f"noise of {LEVEL}", "_noisy", lambda row: f"{row['distance'][1]:.2f}", removing_noise()),
        ("as they are", "", relief, removing_noise()),
        (f"others, noise of {LEVEL}", "_noisy", kept, others),
        ("others, as they are", "", kept, others),
    ):
        yield f"| {title} | {' | '.join(scans)} |"
        yield "|---|" + "---:|" * len(scans)
        for name in names:
            yield f"| `{name}` | {' | '.join(cell(scan + end, name, words) for scan in scans)} |"
        yield ""
    yield "| recipe | runs | written | moved at most, edges | removed at most, of the area |"
    yield "|---|---:|---:|---:|---:|"
    for name in dict.fromkeys(row["recipe"] for row in rows):
        those = [row for row in rows if row["recipe"] == name]
        written = [row for row in those if not row["exit"]]
        moved = max((row["moved"][1] or 0.0 for row in written if row["moved"][1] is not None), default=0.0)
        removed = max((row["removed"][1] or 0.0 for row in written), default=0.0)
        yield f"| `{name}` | {len(those)} | {len(written)} | {moved:.1f} | {removed:.0%} |"


def draw_sheets(scan: Path, recipes: Sequence[str]) -> None:
    """The scan and its results, eight a sheet."""
    there = [(scan.stem, scan), *((name, path) for name in recipes if (path := target_of(scan, name)).exists())]
    meshes = {name: read_file(path).mesh for name, path in there}
    shown = {name: mesh for name, mesh in meshes.items() if len(mesh.faces) or not len(meshes[scan.stem].faces)}
    names = list(shown)[1:]
    tilted = {"azimuth": -40.0, "elevation": 25.0, "up": "z"}
    view = tilted if scan.stem[:4] in ("gear", "terr", "fand", "voxe") else {"azimuth": 180.0} if "angel" in scan.stem else {}
    look = Appearance(columns=3, width=520, height=460, **view)
    for part in range(0, len(names), 8):
        sheet = [scan.stem, *names[part : part + 8]]
        draw_meshes([shown[name] for name in sheet], sheet, look).save(scan.with_name(f"sheet_{scan.stem}_{part // 8}.png"))


def draw_example(folder: Path, target: Path) -> None:
    """The gear with noise, and what each recipe that removes noise makes of it."""
    scan = folder / "gear_noisy.stl"
    shown = {"gear with noise": scan} | {name: target_of(scan, name) for name in removing_noise()}
    look = Appearance(columns=4, width=300, height=230, azimuth=-40.0, elevation=25.0, up="z")
    drawn = draw_meshes([read_file(path).mesh for path in shown.values()], list(shown), look)
    drawn.quantize(64).save(target, optimize=True)


def main() -> int:
    """Run what was not, draw, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scans", type=Path, required=True)
    parser.add_argument("--second", action="store_true", help="the second set, in a folder of its own")
    parser.add_argument("--only", default="", help="parts of names of scans, with commas; all by default")
    parser.add_argument("--recipes", default="", help="the same of recipes")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--picture", type=Path, help="of the gear, of which everyone may have one")
    options = parser.parse_args()
    folder: Path = options.folder
    log = folder / "runs.jsonl"
    if not folder.exists():
        folder.mkdir(parents=True)
        (write_second_inputs if options.second else write_inputs)(folder, options.scans)
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    if not options.table and options.picture is None:
        done = {(row["scan"], row["recipe"]) for row in rows}
        inputs = sorted(p for p in folder.iterdir() if p.suffix in (".ply", ".obj", ".stl") and "+" not in p.name)
        for scan in (p for p in inputs if any(text in p.stem for text in options.only.split(","))):
            names = recipes_of("mesh" if len(read_file(scan).mesh.faces) else "cloud")
            for name in names:
                if (scan.stem, name) not in done and any(text in name for text in options.recipes.split(",")):
                    row = row_of(name, scan)
                    with log.open("a") as file:
                        file.write(json.dumps(row) + "\n")
                    rows.append(row)
            draw_sheets(scan, names)
    if options.picture is not None:
        draw_example(folder, options.picture)
    for line in tables(rows) if options.table else ():
        print(line)
    for row in rows:
        for finding in findings(row):
            print(f"{row['scan']} {row['recipe']}: {finding}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
