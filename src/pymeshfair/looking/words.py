"""Describes measures and comparisons: rows of tables and lines of text, for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ..places import counted, distance_unit, point_text

if TYPE_CHECKING:
    from .comparison import Comparison, Deviation, LengthIn

_MOST_PIECES = 5  # the most pieces that get a line each
MOST_AREAS = 20  # the most areas out of tolerance that are listed
#: A measure, its words, and whether it has a row if all values are 0 or None; see `measure_rows` for clouds and runs by tiles.
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
#: the exponent of the unit of length, by measure
_POWERS = {"area": "²", "volume": "³", "mean_edge": "", "mean_spacing": "", "noise": "", "sharp_edge_length": ""}


def measure_rows(columns: Mapping[str, Mapping[str, Any]], unit: str | None = None) -> list[list[str]]:
    """Returns rows: a measure, and its value for each mesh. Unknown measures of clouds and of runs by tiles have no row."""
    powers = {name: f" ({unit}{power})" for name, power in _POWERS.items() if unit}
    surfaces = [measures for measures in columns.values() if measures.get("faces") or measures.get("edges")]
    incomplete = all(measures.get("faces") == 0 or measures.get("area") is None for measures in columns.values())
    rows = []
    for name, words, always in _MEASURES:
        # In a cloud all vertices are unreferenced, which is no fault.
        values = [measures.get(name) for measures in (surfaces if name == "unreferenced_vertices" else columns.values())]
        if any(values) or (always and not (incomplete and all(value is None for value in values))):
            rows.append([words + powers.get(name, ""), *(_value_text(measures.get(name)) for measures in columns.values())])
    return rows


def became_text(change: Mapping[str, Any], unit: str | None = None) -> str:
    """Returns a sentence on what a run has removed, added and moved.

    `change` has the fields of `pymeshfair.running.shape_change.ShapeChange` by name; `unit` is the unit of the scan, or None.
    """
    removed, added, moved = change["removed"], change["added"], change["moved"]
    parts = []
    if not moved or not moved["same"]:
        parts.append("made a new mesh")
    elif removed["faces"] and added["faces"] and not (removed["vertices"] or added["vertices"]):
        parts.append(f"retriangulated: {counted(added['faces'], 'face')} in place of {counted(removed['faces'], 'face')}")
    else:
        parts += [f"{name} {_part_text(part)}" for name, part in _parts(change).items()]
    if moved and not moved["largest"]:
        parts.append("moved no vertex")
    elif moved:
        length = f"{_in(moved['mean'], unit)} on average, {_in(moved['largest'], unit)}"
        if moved["edges"] is not None:
            length = f"{moved['mean_edges']:.2g} mean {distance_unit(change['area'])} on average, {moved['edges']:.2g}"
        parts.append(f"{'moved' if moved['same'] else 'lies away from the input by'} {length} at most")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}"


def change_lines(change: Mapping[str, Any], unit: str | None = None) -> list[str]:
    """Returns lines on the change of shape by a run; the arguments are those of `became_text`."""
    sides = dict(zip("xyz", change["sides"], strict=True))
    if "removed" not in change:  # a run by tiles measures only the bounding box
        shares = _shares({name: share or None for name, share in sides.items()})
        return [f"changed: {shares}"] if shares else []
    moved, parts = change["moved"], _parts(change)
    because = f", as parts were {' and '.join(parts)}" if parts else ""
    lines = [became_text(change, unit)]
    if moved and moved["same"]:
        lines += [line for name, part in parts.items() for line in _piece_lines(name, part, unit)]
    lines.append(f"changed{because}: {_shares({**sides, 'area': change['area'], 'volume': change['volume']})}")
    if without_noise := change.get("sides_without_noise"):
        lines.append(f"sides, measured without noise at their ends: {_shares(dict(zip('xyz', without_noise, strict=True)))}")
    if moved and moved["largest"]:
        edges = f" ({moved['edges']:.2g} mean {distance_unit(change['area'])})" if moved["edges"] is not None else ""
        lines.append(
            f"{'moved' if moved['same'] else 'away'}: mean {_in(moved['mean'], unit)}, 99 % below {_in(moved['most'], unit)}, "
            f"at most {_in(moved['largest'], unit)}{edges}, vertex {moved['vertex']} at {point_text(moved['place'])}"
        )
    shortest, lost = change.get("relief_from", 0.0), change["relief_lost"]
    relief = f"relief with waves from {shortest:g} mean edges on" if shortest else "relief apart from noise"
    kept = [] if lost is None else [f"{_percent(max(0.0, 1.0 - lost))} of the {relief}"]
    if change["sharp_kept"] is not None:
        kept.append(f"{_percent(change['sharp_kept'])} of the length of sharp edges, including those of noise")
    if kept:
        unknown = "the relief" if lost is None else "shorter waves" if shortest else ""
        note = f"; {unknown} cannot be distinguished from noise" if unknown else ""
        lines.append(f"kept: {', '.join(kept)}{note}")
    if change["turned"]:
        verdict = "a fault: more" if change["folded"] else "no fault: no more"
        lines.append(f"turned over: {counted(change['turned'], 'face')}, {verdict} faces are folded over than before")
    return lines


def _parts(change: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    return {name: change[name] for name in ("removed", "added") if change[name]["vertices"] or change[name]["faces"]}


def _shares(shares: Mapping[str, float | None]) -> str:
    return ", ".join(f"{name} {share:+.2%}" for name, share in shares.items() if share is not None)


def _piece_lines(words: str, part: Mapping[str, Any], unit: str | None) -> Iterator[str]:
    if part["pieces"] < 2:
        return
    for piece in part["largest"][:_MOST_PIECES]:
        share = "" if piece["share"] is None else f", {_percent(piece['share'])} of the area"
        where = f"{_in(piece['size'], unit)} across, at {point_text(piece['place'])}"
        yield f"  {words}: {counted(piece['faces'], 'face')}{share}, {where}"
    if (more := part["pieces"] - _MOST_PIECES) > 0:
        yield f"  {words}: {counted(more, 'smaller piece')}"


def _part_text(part: Mapping[str, Any]) -> str:
    """Returns a text such as "14 loose pieces and 1 part of the rim (1,200 faces): 12.6 % of the area"."""
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


def verdict_text(result: Comparison, unit: str | None = None) -> str:
    """Returns up to three sentences: the distance of the surfaces, the displacement, and whether the tolerance is kept."""
    after, before, moved = result.after_from_before, result.before_from_after, result.displacement

    def text_of(length: LengthIn) -> str:
        if length.mean_edges is None:
            return _in(abs(length.mesh_units), unit)
        return _in(abs(length.mean_edges), _relative_unit(result))

    if result.same_surface:
        text = "Both meshes are the same surface: no place of one lies further than a rounding error from the other."
    elif result.hausdorff.mesh_units <= result.rounding:
        text = f"No difference between the surfaces at {after.samples + before.samples:,} samples."
    elif before.rms.mesh_units > 2.0 * after.rms.mesh_units:
        text = (
            f"BEFORE lies {text_of(before.rms)} from AFTER (root mean square), and {text_of(before.largest)} at most; "
            f"AFTER lies {text_of(after.rms)} from BEFORE."
        )
    else:
        apart = f"{text_of(after.rms)} apart (root mean square), and {text_of(result.hausdorff)} at most"
        side = f"AFTER lies {text_of(after.mean)} {'outwards' if after.mean.mesh_units > 0.0 else 'inwards'} on average"
        text = f"The surfaces lie {apart}; {side}." if result.before["faces"] else f"The points lie {apart}."
    if moved is not None and not moved.largest.mesh_units:
        text += " No vertex moved."
    elif moved is not None:
        text += f" Vertices moved by {text_of(moved.mean)} on average, and by {text_of(moved.largest)} at most."
    if result.tolerance is not None:
        limit = result.tolerance.mesh_units
        shares = f"{_within(after, limit)} of AFTER and {_within(before, limit)} of BEFORE lie within {_in(limit, unit, 6)}"
        areas = counted(len(result.out_of_tolerance), "area")
        text = f"Passed: {shares}. {text}" if result.passed else f"Failed: {shares}, {areas} not. {text}"
    return text


def _within(side: Deviation, tolerance: float) -> str:
    return f"{min(100.0 * (side.within or 0.0), 99.99 if side.largest.mesh_units > tolerance else 100.0):.4g} %"


def area_table(result: Comparison, unit: str | None = None) -> list[list[str]]:
    """Returns the headers and the rows of the furthest areas out of tolerance."""
    length = unit or "mesh units"
    signs = {"after": "+" if result.before["faces"] else "", "before": "+" if result.after["faces"] else ""}
    headers = ["area out of tolerance", "furthest at", f"by ({length})", f"size ({length})", f"area ({length}²)"]
    return [headers] + [
        [f"{k}, of {a.mesh.upper()}", point_text(a.place), f"{a.amount:{signs[a.mesh]}.4g}", f"{a.size:.4g}", f"{a.area:.4g}"]
        for k, a in enumerate(result.out_of_tolerance[:MOST_AREAS], 1)
    ]


def distance_table(result: Comparison, unit: str | None = None) -> list[list[str]]:
    """Returns the headers and the rows of the distances of two surfaces, in three units."""
    after, before, moved = result.after_from_before, result.before_from_after, result.displacement
    part = "area is" if result.after["faces"] else "points are"
    rows = [
        (f"AFTER from BEFORE, mean{' (above 0: outwards)' if result.before['faces'] else ''}", after.mean),
        ("mean without sign", after.mean_size),
        ("root mean square", after.rms),
        ("standard deviation", after.standard_deviation),
        *((f"{percent} % of the {part} nearer than", length) for percent, length in after.percentiles.items()),
        (f"largest, at {point_text(after.place)}", after.largest),
        ("BEFORE from AFTER, root mean square", before.rms),
        (f"largest, at {point_text(before.place)}", before.largest),
    ]
    if moved is not None:
        rows += [
            ("displacement of the vertices, mean", moved.mean),
            ("root mean square", moved.rms),
            (f"largest, vertex {moved.vertex} at {point_text(moved.place)}", moved.largest),
        ]
    return [["", unit or "mesh units", _relative_unit(result), "% of diagonal"]] + [
        [words, *("-" if value is None else f"{value:.4g}" for value in vars(length).values())]
        for words, length in (*rows, ("Hausdorff distance", result.hausdorff))
    ]


def comparison_lines(result: Comparison, unit: str | None = None) -> list[str]:
    """Returns lines on the sampling errors, the upper bound of the Hausdorff distance, and other changes."""
    after, before = result.after_from_before, result.before_from_after
    square = f" {unit}²" if unit else ""
    mean, rms = (_in(error.mesh_units, unit, 2) for error in (after.mean_error, after.rms_error))
    bound = _in(result.hausdorff_at_most.mesh_units, unit, 4)
    surfaces = sum(measures["faces"] > 0 for measures in (result.before, result.after))
    places = ("at the points of clouds", "on faces by area and at the points of clouds", "on faces by area")[surfaces]
    lines = [
        f"distances: {after.samples:,} samples of AFTER and {before.samples:,} of BEFORE, {places}; sampling errors of "
        f"the mean {mean}, of the root mean square {rms}; the Hausdorff distance is at most {bound}"
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
    if (count := len(result.out_of_tolerance)) > MOST_AREAS:
        lines.append(f"areas out of tolerance: {count:,}; the {MOST_AREAS} furthest are listed")
    attributes = {words: getattr(result, f"attributes_{words}") for words in ("kept", "lost", "gained")}
    return [*lines, *(f"{words}: {', '.join(names)}" for words, names in attributes.items() if names)]


def _relative_unit(result: Comparison) -> str:
    return "mean edges" if result.before["mean_edge"] else "mean spacings"


def _in(value: float, unit: str | None, digits: int = 3) -> str:
    return f"{value:.{digits}g}{f' {unit}' if unit else ''}"


def _value_text(value: float | str | None) -> str:
    if value is None or isinstance(value, str):  # a text such as "inf" is a number that JSON cannot hold
        return value or "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:,.6g}"
