"""Measures and comparisons in words: the rows of tables and the lines below them, for the terminal and for pages alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .comparison import Comparison, LengthIn

#: pieces that are shown one by one
_SHOWN = 5
#: measure, its words in the table, and whether it is shown even where it is 0 or unknown
_MEASURES = (
    ("vertices", "vertices", True),
    ("faces", "faces", True),
    ("border_edges", "border edges", True),
    ("components", "components", True),
    ("area", "area", True),
    ("volume", "volume", False),
    ("mean_edge", "mean edge", True),
    ("mean_spacing", "mean spacing", False),
    ("roughness", "roughness (degrees between neighbouring faces)", True),
    ("degenerate_faces", "degenerate faces", False),
    ("folded_faces", "folded faces", False),
    ("unreferenced_vertices", "unreferenced vertices", False),
    ("non_manifold_edges", "non-manifold edges", False),
    ("non_manifold_vertices", "non-manifold vertices", False),
    ("border_loops", "border loops", False),
    ("holes", "holes", False),
    ("genus", "genus", False),
    ("triangle_quality", "triangle quality (1: equilateral)", False),
    ("self_intersecting_faces", "self-intersecting faces", False),
    ("noise", "noise along the normals", False),
    ("sharp_edge_length", "length of sharp edges", False),
)
#: of the unit of the scan, by the measures that have one
_POWERS = {"area": "²", "volume": "³", "mean_edge": "", "mean_spacing": "", "noise": "", "sharp_edge_length": ""}


def measure_rows(columns: Mapping[str, Mapping[str, Any]], unit: str | None = None) -> list[list[str]]:
    """A measure's name and its value for each mesh; rare measures that are 0 or unknown in all of them are left out."""
    powers = {name: f" ({unit}{power})" for name, power in _POWERS.items() if unit}
    surfaces = [measures for measures in columns.values() if measures.get("faces") or measures.get("edges")]
    clouds = all(measures.get("faces") == 0 for measures in columns.values())
    rows = []
    for name, words, always in _MEASURES:
        # The points of a cloud wait for no face, and have no borders and no area.
        values = [measures.get(name) for measures in (surfaces if name == "unreferenced_vertices" else columns.values())]
        if any(values) or (always and not (clouds and all(value is None for value in values))):
            rows.append([words + powers.get(name, ""), *(_shown(measures.get(name)) for measures in columns.values())])
    return rows


def became_text(change: Mapping[str, Any], unit: str | None = None) -> str:
    """The removals, additions and moves of a run, `pymeshfair.running.shape_change.ShapeChange` by name, in one sentence.

    `unit` is that of the scan, or None; so below.
    """
    removed, added, moved = change["removed"], change["added"], change["moved"]
    parts = []
    if not moved or not moved["same"]:
        parts.append("made a new mesh")
    elif removed["faces"] and added["faces"] and not (removed["vertices"] or added["vertices"]):
        parts.append(f"cut the surface otherwise: {counted(added['faces'], 'face')} of {counted(removed['faces'], 'other face')}")
    else:
        parts += [f"{name} {_part(part)}" for name, part in _parts(change).items()]
    if moved and not moved["largest"]:
        parts.append("moved no vertex")
    elif moved:
        length = f"{_in(moved['mean'], unit)} on average, {_in(moved['largest'], unit)}"
        if moved["edges"] is not None:
            length = f"{moved['mean_edges']:.2g} mean edges on average, {moved['edges']:.2g}"
        parts.append(f"{'moved' if moved['same'] else 'lies away from the input by'} {length} at most")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}"


def change_lines(change: Mapping[str, Any], unit: str | None = None) -> list[str]:
    """The change of shape by a run, `pymeshfair.running.shape_change.ShapeChange` by name, as lines below the table."""
    sides = dict(zip("xyz", change["sides"], strict=True))
    if "removed" not in change:  # done by tiles, which measure no more than the box
        shares = _shares({name: share or None for name, share in sides.items()})
        return [f"changed: {shares}"] if shares else []
    moved, parts = change["moved"], _parts(change)
    because = f", as parts were {' and '.join(parts)}" if parts else ""
    lines = [became_text(change, unit)]
    if moved and moved["same"]:
        lines += [line for name, part in parts.items() for line in _pieces(name, part, unit)]
    lines.append(f"changed{because}: {_shares({**sides, 'area': change['area'], 'volume': change['volume']})}")
    if aside := change.get("sides_without_noise"):
        lines.append(f"noise at the ends aside: {_shares(dict(zip('xyz', aside, strict=True)))}")
    if moved and moved["largest"]:
        x, y, z = moved["place"]
        edges = f" ({moved['edges']:.2g} mean edges)" if moved["edges"] is not None else ""
        lines.append(
            f"{'moved' if moved['same'] else 'away'}: mean {_in(moved['mean'], unit)}, 99 % below {_in(moved['most'], unit)}, "
            f"at most {_in(moved['largest'], unit)}{edges}, vertex {moved['vertex']} at {x:.6g}, {y:.6g}, {z:.6g}"
        )
    shortest, lost = change.get("relief_from", 0.0), change["relief_lost"]
    relief = f"relief from {shortest:g} mean edges on" if shortest else "relief beside the noise"
    kept = [] if lost is None else [f"{_percent(max(0.0, 1.0 - lost))} of the {relief}"]
    if change["sharp_kept"] is not None:
        kept.append(f"{_percent(change['sharp_kept'])} of the length of sharp edges, those of noise among them")
    if kept:
        unknown = "the" if lost is None else "shorter" if shortest else ""
        unseen = f"; of {unknown} relief nothing can be told beside the noise" if unknown else ""
        lines.append(f"kept: {', '.join(kept)}{unseen}")
    if change["turned"]:
        verdict = "a fault: more" if change["folded"] else "no fault: no more"
        lines.append(f"turned over: {counted(change['turned'], 'face')}, {verdict} faces are folded over than before")
    return lines


def _parts(change: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """What was removed and added, if there is any."""
    return {name: change[name] for name in ("removed", "added") if change[name]["vertices"] or change[name]["faces"]}


def _shares(shares: Mapping[str, float | None]) -> str:
    return ", ".join(f"{name} {share:+.2%}" for name, share in shares.items() if share is not None)


def _pieces(words: str, part: Mapping[str, Any], unit: str | None) -> Iterator[str]:
    """The largest of several pieces, one line each."""
    if part["pieces"] < 2:
        return
    for piece in part["largest"][:_SHOWN]:
        share = "" if piece["share"] is None else f", {_percent(piece['share'])} of the area"
        yield f"  {words}: {counted(piece['faces'], 'face')}{share}, {_in(piece['size'], unit)} across, at {_at(piece['place'])}"
    if (more := part["pieces"] - _SHOWN) > 0:
        yield f"  {words}: {counted(more, 'smaller piece')}"


def _part(part: Mapping[str, Any]) -> str:
    """Such as "14 loose pieces and a rim: 12.6 % of the area"."""
    if not part["faces"]:
        return counted(part["vertices"], "vertex", "vertices")
    kinds = (
        (part["loose"], "loose piece", "loose pieces"),
        (part["rims"], "part of the rim", "parts of the rim"),
        (part["pieces"] - part["loose"] - part["rims"], "part inside", "parts inside"),
    )
    pieces = [counted(*kind) for kind in kinds if kind[0]]
    share = "" if part["share"] is None else f": {_percent(part['share'])} of the area"
    return f"{' and '.join(pieces)} ({counted(part['faces'], 'face')}){share}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def counted(count: int, one: str, several: str = "") -> str:
    """A number of things, such as ``1 step`` or ``1,200 steps``."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def verdict_text(result: Comparison, unit: str | None = None) -> str:
    """The distance of the surfaces in a sentence or three; with a tolerance whether they lie within it."""
    there, here, moved = result.after_from_before, result.before_from_after, result.displacement
    if result.same_surface:
        text = "Both meshes are the same surface: no place lies further than rounding from the other."
    elif result.hausdorff.mesh_units <= result.rounding:
        text = f"No difference between the surfaces at {there.samples + here.samples:,} samples of their faces."
    else:
        text = (
            f"The surfaces lie {_in_edges(there.rms, unit)} apart (root mean square), and {_in_edges(result.hausdorff, unit)} at "
            f"most, {'outwards' if there.mean.mesh_units > 0.0 else 'inwards'} by {_in_edges(there.mean, unit, sign=False)} "
            "on average."
        )
    if moved is not None and not moved.largest.mesh_units:
        text += " No vertex moved."
    elif moved is not None:
        text += f" Vertices moved by {_in_edges(moved.mean, unit)} on average, and by {_in_edges(moved.largest, unit)} at most."
    if result.tolerance is not None and there.within is not None and here.within is not None:
        parts = f"{100 * there.within:.4g} % of AFTER and {100 * here.within:.4g} % of BEFORE"
        shares = f"{parts} lie within {_in(result.tolerance.mesh_units, unit, 6)}"
        areas = counted(len(result.out_of_tolerance), "area")
        text = f"Passed: {shares}. {text}" if result.passed else f"Failed: {shares}, {areas} not. {text}"
    return text


def area_table(result: Comparison, most: int, unit: str | None = None) -> list[list[str]]:
    """The areas out of tolerance, the furthest first, below the headers of their columns; `unit` is that of the scan."""
    length = unit or "mesh units"
    headers = ["area out of tolerance", "furthest at", f"by ({length})", f"size ({length})", f"area ({length}²)"]
    return [headers] + [
        [f"{k}, of {a.mesh.upper()}", _at(a.place), f"{a.amount:+.4g}", f"{a.size:.4g}", f"{a.area:.4g}"]
        for k, a in enumerate(result.out_of_tolerance[:most], 1)
    ]


def distance_table(result: Comparison, unit: str | None = None) -> list[list[str]]:
    """The distances of the two surfaces, in three units, below the headers of their columns."""
    there, here, moved = result.after_from_before, result.before_from_after, result.displacement
    rows = [
        ("AFTER from BEFORE, mean (above 0: outwards)", there.mean),
        ("mean without sign", there.mean_size),
        ("root mean square", there.rms),
        ("standard deviation", there.standard_deviation),
        *((f"{percent} % of the area keep below", length) for percent, length in there.percentiles.items()),
        (f"largest, at {_at(there.place)}", there.largest),
        ("BEFORE from AFTER, root mean square", here.rms),
        (f"largest, at {_at(here.place)}", here.largest),
    ]
    if moved is not None:
        rows += [
            ("displacement of the vertices, mean", moved.mean),
            ("root mean square", moved.rms),
            (f"largest, vertex {moved.vertex} at {_at(moved.place)}", moved.largest),
        ]
    return [["", unit or "mesh units", "mean edges", "% of diagonal"]] + [
        [words, *("-" if value is None else f"{value:.4g}" for value in vars(length).values())]
        for words, length in (*rows, ("Hausdorff distance", result.hausdorff))
    ]


def comparison_lines(result: Comparison, unit: str | None = None) -> list[str]:
    """The bound for places between the samples, and other changes, one line each."""
    there, here = result.after_from_before, result.before_from_after
    square = f" {unit}²" if unit else ""
    lines = [
        f"distances: {there.samples:,} samples of AFTER and {here.samples:,} of BEFORE, on faces by area; sampling errors of the "
        f"mean {_in(there.mean_error.mesh_units, unit, 2)}, of the root mean square {_in(there.rms_error.mesh_units, unit, 2)}; "
        f"the Hausdorff distance is at most {_in(result.hausdorff_at_most.mesh_units, unit, 4)}"
    ]
    for words, value in (("area", result.area_change), ("volume", result.volume_change)):
        if value is not None:
            lines.append(f"{words}: {value:+.4g} %")
    if result.normal_deviation is not None:
        lines.append(
            f"normals: {result.normal_deviation:.3g} degrees apart on average, {result.largest_normal_deviation:.3g} at most; "
            f"{result.flipped_faces:,} faces flipped"
        )
    if result.sharp_edges_kept is not None:
        lines.append(
            f"sharp edges (from {result.sharp_angle:g} degrees): {100 * result.sharp_edges_kept:.1f} % of their length kept"
        )
    if result.added_area is not None:
        lines.append(
            f"more than a mean edge away: {result.added_area:.6g}{square} of area added, "
            f"{result.removed_area:.6g}{square} removed"
        )
    named = {words: getattr(result, f"attributes_{words}") for words in ("kept", "lost", "gained")}
    return [*lines, *(f"{words}: {', '.join(names)}" for words, names in named.items() if names)]


def _in_edges(length: LengthIn, unit: str | None, *, sign: bool = True) -> str:
    """A length in mean edges where there are any."""
    value, unit = (length.mesh_units, unit) if length.mean_edges is None else (length.mean_edges, "mean edges")
    return _in(value if sign else abs(value), unit)


def _in(value: float, unit: str | None, digits: int = 3) -> str:
    return f"{value:.{digits}g}{f' {unit}' if unit else ''}"


def _at(place: tuple[float, float, float]) -> str:
    return ", ".join(f"{c:.6g}" for c in place)


def _shown(value: float | str | None) -> str:
    if value is None or isinstance(value, str):  # a text stands for a number beyond the largest
        return value or "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:,.6g}"
