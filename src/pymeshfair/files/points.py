"""Reads and writes texts of points: one row of numbers for each point, after optional lines with titles and a count.

PTX files have grids of points from scanners, each after a header with its size, the scanner's pose and a matrix.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..filters.mesh import Bools, Floats
from ..mesh_data import MeshData, Source, as_levels
from ..mesh_data.mesh_data import VERTEX_ATTRIBUTES, Array, source_ids
from .errors import ContentsError
from .inputs import Reading, References, unended
from .outputs import Writing
from .tokens import INTEGER, WORD, Tokens, at_line, numbers_of, refuse, rows, tokenise

#: a binary point set of Expe: its header, and the types of its properties
_EXPE = re.compile(rb"\[Expe/PointSet/Binary/0\.1\]\n((?:property \w+ \d+\n)+)nofpoints (\d+)\ndata\n")
_OF_EXPE = {"position": ("<f4", 3), "normal": ("<f4", 3), "radius": ("<f4", ()), "color": ("u1", 4)}
_PLACE, _COLOR, _NORMAL = ("x", "y", "z"), ("red", "green", "blue"), ("nx", "ny", "nz")
#: alternative titles of columns
_TITLES = {"r": "red", "g": "green", "b": "blue", "i": "intensity"} | {f"normal{axis}": f"n{axis}" for axis in "xyz"}
#: how many numbers each line of a PTX header has: columns, rows, four lines of the scanner's pose, four of a matrix
_HEAD = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
_PLAIN, _COLOURED = 4, 7  # how many numbers a PTX point has: position and intensity, or position, intensity and colour
_ROUNDED = 1e-6  # an upper bound of the error of numbers with six decimals


@dataclass(frozen=True, eq=False)
class PointsDocument:
    """What the writer needs of a text of points."""

    columns: tuple[str, ...]  # the attribute in each column
    titles: bytes = b""  # the line of titles
    separator: str = " "  # between numbers
    counted: bool = False  # whether a line with the number of points precedes the points
    shares: Floats | None = None  # (n, 3) red, green and blue, if the text has them as shares from 0 to 1


def read_points(path: Path, references: References) -> Reading:
    """Reads a text of points."""
    data = path.read_bytes()
    if (head := _EXPE.match(data)) is not None:
        return _expe(path, data, head)
    if b"\0" in data[:4096]:
        raise ContentsError("it is no text")
    separator = _separator(data)
    tokens = tokenise(data if separator == " " else data.replace(separator.encode(), b" "), joins=True)
    titles, titled, start = _titles(tokens, data, separator)
    lines = np.arange(start, len(tokens.numbers))
    if not len(lines):
        raise ContentsError("it holds no points")
    lengths = tokens.lengths[lines]
    counted = bool(lengths[0] == 1 and tokens.kinds[tokens.first[start]] == INTEGER)
    if counted:
        declared, lines, lengths = int(tokens.values[tokens.first[start]]), lines[1:], lengths[1:]
        if declared != len(lines):
            raise ContentsError(f"it declares {declared:,} points, but has {len(lines):,}")
    width = int(lengths[0]) if len(lines) else 0
    if width < 3:
        raise ContentsError(f"its rows have {width} numbers; a point has at least 3")
    refuse(tokens, lines, lengths != width, f"has {{}} numbers, but the rows before it have {width}", lengths)
    values = numbers_of(tokens, lines, 0, width)
    whole = (tokens.kinds[tokens.first[lines][:, None] + np.arange(width)] == INTEGER).all(axis=0)
    titles_fit = len(titled) == width == len(set(titled)) and set(_PLACE) <= set(titled)
    columns = titled if titles_fit else _guessed(values, whole)
    vertices, attributes, shares = _attributes(columns, values, whole)
    extras = [f"its titles {titles.decode('utf-8', 'replace')!r}"] if titles and not titles_fit else []
    extras += ["comments"] if data.count(b"#") > titles.count(b"#") else []
    if shares is not None and np.abs(as_levels(shares) / 255 - shares).max() > _ROUNDED:
        extras.append("decimals of colours")
    source = Source(path, "xyz", PointsDocument(columns, titles, separator, counted, shares), tuple(extras))
    return Reading(MeshData(vertices=vertices, vertex_attributes=attributes, source=source), unended(data))


def _separator(data: bytes) -> str:
    """Returns the separator of numbers: a semicolon, a comma or a blank; refuses decimal commas, ignores comments."""
    data = re.sub(rb"#[^\r\n]*", b"", data) if b"#" in data else data
    if b";" in data:
        if b"," in data:
            raise ContentsError("it has commas and semicolons; decimals are written with a point")
        return ";"
    if b"," not in data:
        return " "
    lines = [line for line in data[:65536].splitlines() if b"," in line]
    if any(len(line.replace(b", ", b",").split()) > 1 for line in lines[1:] or lines):  # the first line may have titles
        raise ContentsError("it has commas and blanks between numbers; decimals are written with a point")
    return ","


def _titles(tokens: Tokens, data: bytes, separator: str) -> tuple[bytes, tuple[str, ...], int]:
    """Returns the line of titles, which may be a comment; the attributes in it; and the number of the first row."""
    first = data.removeprefix(b"\xef\xbb\xbf").lstrip().partition(b"\n")[0].rstrip()
    text = first.decode("utf-8", "replace").lower().replace("normal_", "normal")
    parts = text.split(separator) if separator != " " and separator in text else re.findall(r"\w+", text)
    names = ["_".join(re.findall(r"\w+", part)) for part in parts]
    titled = tuple(f"{name}_" if name in VERTEX_ATTRIBUTES else name for name in (_TITLES.get(n, n) for n in names))
    if first.startswith(b"#"):
        return (first, titled, 0) if set(_PLACE) <= set(titled) else (b"", (), 0)
    words = len(tokens.numbers) > 0 and bool((tokens.kinds[: tokens.first[1]] == WORD).all())
    if words and (set(_PLACE) <= set(titled) or not any(c.isdigit() for c in first.decode("latin-1"))):
        return first, titled, 1
    return b"", (), 0


def _guessed(values: Floats, whole: Bools) -> tuple[str, ...]:
    width = values.shape[1]
    rgb = slice(4, 7) if width == 7 else slice(3, 6)
    are_levels = width > 5 and whole[rgb].all() and values[:, rgb].min() >= 0 and values[:, rgb].max() <= 255
    lengths = np.linalg.norm(np.clip(values[:, -3:], -2.0, 2.0), axis=1)  # clipped: squares of large numbers overflow
    are_normals = np.abs(lengths[lengths > 0] - 1.0).max(initial=0.0) <= 0.01  # normals may be written with two decimals
    are_colors = are_levels and not (are_normals and lengths.any())
    if width == 6 and (are_colors or are_normals):
        return (*_PLACE, *(_COLOR if are_colors else _NORMAL))
    if width == 7 and not are_levels:
        raise ContentsError("the last three numbers of its rows are no colours from 0 to 255")
    if width == 9 and are_levels and are_normals:
        return (*_PLACE, *_COLOR, *_NORMAL)
    if width in (3, 4, 7):
        return (*_PLACE, "intensity", *_COLOR)[:width]
    return (*_PLACE, *(f"column_{k}" for k in range(4, width + 1)))


def _attributes(columns: tuple[str, ...], values: Floats, whole: Bools) -> tuple[Floats, dict[str, Array], Floats | None]:
    column = {name: k for k, name in enumerate(columns)}
    vectors = {names: values[:, [column[n] for n in names]] for names in (_PLACE, _COLOR, _NORMAL) if set(names) <= set(columns)}
    attributes: dict[str, Array] = {}
    if _NORMAL in vectors:
        attributes["normals"] = vectors[_NORMAL]
    shares: Floats | None = None
    if (colors := vectors.get(_COLOR)) is not None:
        top = 255.0 if whole[[column[n] for n in _COLOR]].all() else 1.0
        if colors.min() >= 0 and colors.max() <= top:
            shares = colors if top == 1 else None
            attributes["colors"] = as_levels(np.pad(colors / top, ((0, 0), (0, 1)), constant_values=1.0))
    standard = {*_PLACE, *(_NORMAL if _NORMAL in vectors else ()), *(_COLOR if "colors" in attributes else ())}
    for name, k in column.items():
        if name not in standard:
            small = whole[k] and np.abs(values[:, k]).max() < 1 << 31
            attributes[name] = values[:, k].astype(np.int32) if small else values[:, k]
    return vectors[_PLACE], attributes, shares


def _expe(path: Path, data: bytes, head: re.Match[bytes]) -> Reading:
    sizes = {name: int(size) for name, size in re.findall(r"property (\w+) (\d+)", head[1].decode("ascii"))}
    count, row_size, size = int(head[2]), sum(sizes.values()), len(data) - head.end()
    if not count or size != count * row_size:
        raise ContentsError(f"it declares {count:,} points of {row_size:,} bytes, but {size:,} bytes follow")
    row = np.dtype([(name, *_OF_EXPE.get(name, ("V1", size))) for name, size in sizes.items()])
    if "position" not in sizes or row.itemsize != row_size:
        raise ContentsError("it is a point set of Expe of an unknown kind")
    points = np.frombuffer(data, row, count, head.end())
    kinds = (("normal", "normals", np.float64), ("radius", "radii", np.float64), ("color", "colors", np.uint8))
    attributes = {name: points[key].astype(kind) for key, name, kind in kinds if key in sizes}
    source = Source(path, "xyz", extras=tuple(f"property {name!r}" for name in sizes if name not in _OF_EXPE))
    return Reading(MeshData(vertices=points["position"], vertex_attributes=attributes, source=source))


def read_ptx(path: Path, references: References) -> Reading:
    """Reads the points of all grids, transformed by the matrices of their headers."""
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        raise ContentsError("it is no text")
    if b"#" in data:
        raise ContentsError("it has comments, which the format does not allow")
    tokens = tokenise(data)
    grids, positions, line = [], [], 0
    while line < len(tokens.numbers):
        grid, position = _grid(tokens, line)
        grids.append(grid)
        positions += [position] if position else []
        line += len(_HEAD) + len(grid)
    extras = (f"the scanner's positions ({len(positions):,})",) if len(positions) > 1 else tuple(positions)
    widest = max((grid.shape[1] for grid in grids), default=_PLAIN)
    bare = sum(grid.shape[1] < widest for grid in grids if len(grid))
    grids = [np.pad(grid, ((0, 0), (0, widest - grid.shape[1])), constant_values=255.0) for grid in grids]
    rows = np.concatenate([np.empty((0, widest)), *grids])
    if not len(rows):
        raise ContentsError("it holds no points")
    measured = rows[~np.isnan(rows[:, 0])]
    attributes: dict[str, Array] = {"intensity": measured[:, 3]}
    if measured.shape[1] == _COLOURED:
        colors = np.append(measured[:, 4:], np.full((len(measured), 1), 255.0), axis=1)
        if not ((colors >= 0) & (colors <= 255) & (colors == np.rint(colors))).all():
            raise ContentsError("the last three numbers of its points are no colours from 0 to 255")
        attributes["colors"] = colors.astype(np.uint8)
    missing = len(rows) - len(measured)
    doubts = [f"{missing:,} positions in its grids have no measured point and are left out"] if missing else []
    doubts += [f"{bare:,} of its {len(grids):,} grids have no colours, and are white"] if bare else []
    mesh = MeshData(vertices=measured[:, :3], vertex_attributes=attributes, source=Source(path, "ptx", extras=extras))
    return Reading(mesh, (*unended(data), *doubts))


def _grid(tokens: Tokens, line: int) -> tuple[Floats, str]:
    """Returns the points of the grid whose header begins at `line`, NaN where unmeasured, and its scanner position in words."""
    first = line + len(_HEAD)
    sizes = tokens.first[line : line + 2]
    is_head = tokens.lengths[line:first].tolist() == list(_HEAD)
    if not is_head or (tokens.kinds[sizes] != INTEGER).any() or (tokens.values[sizes] < 0).any():
        raise at_line(tokens, line, "begins no grid (columns, rows, four lines of the scanner's pose, four of a matrix)")
    count = int(min(tokens.values[sizes].prod(), 1 << 53))
    lengths = tokens.lengths[first : first + count]
    if len(lengths) < count:
        raise ContentsError(f"one of its grids declares {count:,} points, but {len(lengths):,} lines follow")
    wrong = (lengths != lengths[:1]) | ~np.isin(lengths, (_PLAIN, _COLOURED))
    why = "has {} numbers; points have 4 or 7, the same in the whole grid"
    refuse(tokens, np.arange(first, first + count), wrong, why, lengths)
    position = numbers_of(tokens, np.arange(line + 2, line + 6), 0, 3)[0]
    matrix = numbers_of(tokens, np.arange(line + 6, first), 0, 4)  # its last row is the translation
    rows = numbers_of(tokens, np.arange(first, first + count), 0, int(lengths[0]) if count else _PLAIN)
    if not np.allclose(matrix[:, 3], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=_ROUNDED):
        raise ContentsError("the last column of a grid's matrix is not 0 0 0 1")
    missing = ~rows[:, :3].any(axis=1)
    if is_moved := not np.array_equal(matrix, np.eye(4)):
        finite = ~missing & np.isfinite(rows[:, :3]).all(axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            rows[:, :3] = rows[:, :3] @ matrix[:3, :3] + matrix[3, :3]
        if not np.isfinite(rows[finite, :3]).all():
            raise ContentsError("a grid's matrix makes points infinite")
    rows[missing, :3] = np.nan
    return rows, f"the scanner's position {' '.join(f'{x:g}' for x in position)}" if is_moved or position.any() else ""


def write_points(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Writes the columns of the source text; default columns without one, from .pts to .xyz, and from other formats to .pts."""
    counted, source, document = writing.extension == "pts", mesh.source, mesh.document(PointsDocument)
    extras = () if document is None or source is None else source.extras
    is_of_pts = source is not None and source.path.suffix.lower() == ".pts"
    if document is None or (is_of_pts != counted and writing.extension in ("pts", "xyz")):
        document = PointsDocument((*_PLACE, "intensity", *_COLOR) if counted else (*_PLACE, *_NORMAL), counted=counted)
    values: dict[str, Array] = dict(zip(_PLACE, mesh.vertices.T, strict=True))
    lost = []
    for name, attribute in mesh.vertex_attributes.items():
        if name == "colors":
            colors = attribute[:, :3]
            if document.shares is not None:
                ids = source_ids(mesh.vertex_ids, len(mesh.vertices))
                same = (ids >= 0) & (as_levels(document.shares[ids]) == colors).all(axis=1)
                colors = np.where(same[:, None], document.shares[ids], colors / 255)
            columns = dict(zip(_COLOR, colors.T, strict=True))
        elif name == "normals":
            columns = dict(zip(_NORMAL, attribute.T, strict=True))
        else:
            columns = {name: 1 * attribute} if attribute.ndim == 1 and name not in values else {}  # 1 and 0 for booleans
        if columns and set(columns) <= set(document.columns):
            values |= columns
        elif name not in VERTEX_ATTRIBUTES or name in ("colors", "normals"):
            lost.append({"colors": "vertex colours", "normals": "vertex normals"}.get(name, name))
    names = tuple(name for name in document.columns if name in values)
    written = [values[name] for name in names]
    if document.titles:
        mark = document.titles.removesuffix(document.titles.lstrip(b"#/ "))  # of a comment
        titles = document.titles if names == document.columns else mark + document.separator.join(names).encode()
        target.write(titles + b"\n")
    if document.counted:
        target.write(b"%d\n" % len(mesh.vertices))
    target.writelines(rows(document.separator.join(["%r"] * len(written)), written))
    left_out = [name for name in extras if name == "comments" or (name == "decimals of colours" and document.shares is None)]
    notes = [f"the {name} of the text that was read are left out" for name in left_out]
    return (*notes, *([f"it does not hold {', '.join(lost)} of the mesh; .ply keeps them"] if lost else []))
