"""A survey to LAZ by tiles, killed and resumed: ``python benchmarks/survey.py FOLDER [--format F] [--points N] [--kills N]``.

Writes terrain with flyers as LAZ 1.4 of point format 6, with a coordinate reference system and a dimension of its own; or the
same with the octree of COPC; or an E57 file with intensities, colours, a pose, and the row and column of each point. Cleans it
by ``run clean_point_cloud --tiles --memory 1GB``, once to the end, and once killed (kill -9) and resumed. Prints times, memory,
whether both outputs have the same bytes, how many flyers are left, and what is not as it was in the points that are left.
"""

from __future__ import annotations

import argparse
import resource
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, BinaryIO

import laspy
import lazrs
import numpy as np
from cloud_strays import terrain
from laspy._compression.lazrsbackend import LazrsPointWriter
from numpy.typing import NDArray

#: a point every half metre or so, and so many in a sheet of terrain
SPACING, SHEET = 0.5, 1_000_000
ORIGIN = [5e5, 5.4e6, 300.0]
#: of a row of the E57 file, and its colours
COLUMNS, COLORS = 1 << 14, ("colorRed", "colorGreen", "colorBlue")
CRS = (
    'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",DATUM["European_Terrestrial_Reference_System_1989",SPHEROID["GRS 1980",'
    '6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","25832"]]'
)


def survey(count: int) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """(n, 3) sheets of terrain side by side, with the density of a survey and no order, and which of the points are flyers."""
    sheets = max(1, count // SHEET)
    each, columns = count // sheets, int(np.ceil(sheets**0.5))
    side, parts, flying = SPACING * each**0.5, [], []
    for number in range(sheets):
        good, flyers = terrain(each, side=side, seed=number)
        parts.append(np.add(np.concatenate([good, flyers]), [side * (number % columns), side * (number // columns), 0.0]))
        flying.append(np.arange(len(parts[-1])) >= len(good))
    order = np.random.default_rng(2).permutation(sum(map(len, parts)))
    return np.concatenate(parts)[order], np.concatenate(flying)[order]


def lidar(points: NDArray[np.float64]) -> laspy.LasData:
    """All that a scanner says of them; the time of a point is its number over 70,000."""
    random = np.random.default_rng(2)
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = [1e-3] * 3, ORIGIN
    header.add_extra_dim(laspy.ExtraBytesParams("amplitude", "uint16"))
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(CRS))
    header.global_encoding.wkt = True
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.add(points, ORIGIN).T
    for name, most in (("intensity", 60000), ("classification", 20), ("return_number", 5), ("amplitude", 9999)):
        cloud[name] = random.integers(0, most, len(points))
    cloud.gps_time = np.arange(len(points)) / 7e4
    return cloud


class _Nodes(LazrsPointWriter):  # type: ignore[misc]
    """Compresses chunks of any size."""

    def __init__(self, dest: BinaryIO, form: laspy.PointFormat) -> None:
        super().__init__(dest, form, parallel=False)
        self.vlr = lazrs.LazVlr.new_for_compression(form.id, form.num_extra_bytes, True)


class _CopcWriter(laspy.LasWriter):  # type: ignore[misc]
    """Writes a node of the octree after the other."""

    def _create_laz_backend(self, laz_backends: object) -> _Nodes:
        return _Nodes(self.dest, self.header.point_format)


def write_copc(path: Path, cloud: laspy.LasData) -> None:
    """The points in an octree: a point is on level l with a share of 4^l, in the chunk of its voxel there."""
    levels = max(1, int(np.ceil(np.log(len(cloud) / 50_000) / np.log(4))) + 1)
    low, side = cloud.xyz.min(axis=0), 1.001 * float(np.ptp(cloud.xyz, axis=0).max())
    random = np.random.default_rng(4)
    level = random.choice(levels, len(cloud), p=4.0 ** np.arange(levels) / (4.0 ** np.arange(levels)).sum())
    voxel = ((cloud.xyz - low) / side * 2.0 ** level[:, None]).astype(np.int64)
    key = ((level * 1024 + voxel[:, 0]) * 1024 + voxel[:, 1]) * 1024 + voxel[:, 2]
    order = np.argsort(key, kind="stable")
    begins = np.flatnonzero(np.append(True, np.diff(key[order]) > 0))
    header = cloud.header
    header.vlrs.insert(0, laspy.VLR("copc", 1, "copc info", bytes(160)))
    entries: dict[tuple[int, ...], tuple[int, int, int]] = {}
    with path.open("wb") as file:
        with _CopcWriter(file, header, do_compress=True, closefd=False) as writer:
            for begin, end in zip(begins, [*begins[1:], len(order)], strict=True):
                start = file.tell() + (0 if entries else 8)  # before the first chunk is the place of the table
                rows = order[begin:end]
                writer.write_points(cloud.points[rows])
                writer.point_writer.compressor.finish_current_chunk()
                named = (int(level[rows[0]]), *voxel[rows[0]].tolist())
                entries[named] = start, file.tell() - start, len(rows)
            for depth, *place in list(entries):  # voxels without points of their own, above others
                for up in range(1, depth + 1):
                    entries.setdefault((depth - up, *(axis >> up for axis in place)), (0, 0, 0))
            pages = b"".join(struct.pack("<4iQ2i", *named, *where) for named, where in entries.items())
            records = laspy.vlrs.vlrlist.VLRList([laspy.VLR("copc", 1000, "hierarchy", pages)])
            writer.write_evlrs(records)
            place = writer.header.start_of_first_evlr + 60
        times = float(cloud.gps_time.min()), float(cloud.gps_time.max())
        info = struct.pack("<5d2Q2d11Q", *(low + side / 2), side / 2, side / 128, place, 32 * len(entries), *times, *[0] * 11)
        file.seek(375 + 54)
        file.write(info)


def write_e57(path: Path, points: NDArray[np.float64]) -> None:
    """One scan around its own origin, placed by its pose; the number of a point is in its row and column."""
    import pye57

    random, numbers = np.random.default_rng(2), np.arange(len(points))
    fields: dict[str, NDArray[Any]] = {f"cartesian{axis}": points[:, k] for k, axis in enumerate("XYZ")}
    fields |= {"intensity": random.random(len(points), np.float32)}
    fields |= {name: random.integers(0, 256, len(points)).astype(np.uint8) for name in COLORS}
    fields |= {"rowIndex": (numbers // COLUMNS).astype(np.uint16), "columnIndex": (numbers % COLUMNS).astype(np.uint16)}
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(fields, rotation=np.array([1.0, 0.0, 0.0, 0.0]), translation=np.array(ORIGIN))


def command(scan: Path, output: Path, *more: str) -> list[str]:
    """The run by tiles."""
    own = (sys.executable, "-m", "pymeshfair", "run", "clean_point_cloud", str(scan), "-o", str(output))
    return [*own, "--tiles", "--memory", "1GB", "--resume", *more]


def differences(before: Path, after: Path) -> tuple[NDArray[np.int64], list[str]]:
    """The numbers of the points that are left, and what they have not as it was."""
    new = laspy.read(after)
    if before.suffix == ".e57":
        import pye57

        with pye57.E57(str(before)) as file:
            old = file.read_scan_raw(0)
        rows = np.asarray(new["rowIndex"]).astype(np.int64) * COLUMNS + np.asarray(new["columnIndex"])
        bad = [f"color{c}" for c in ("Red", "Green", "Blue") if (old[f"color{c}"][rows] * np.uint16(257) != new[c.lower()]).any()]
        if (np.rint(old["intensity"][rows].astype(np.float64) * 65535.0) != new.intensity).any():
            bad.append("intensity")
        places = np.stack([old[f"cartesian{axis}"][rows] for axis in "XYZ"], axis=1) + ORIGIN
        return rows, bad + ["places"] * bool((np.abs(places - new.xyz) > 0.51 * new.header.scales).any())
    cloud = laspy.read(before)
    rows = np.rint(np.asarray(new.gps_time) * 7e4).astype(np.int64)
    place = np.empty(len(cloud), np.int64)  # the octree has the points in another order
    place[np.rint(np.asarray(cloud.gps_time) * 7e4).astype(np.int64)] = np.arange(len(cloud))
    names = [name for name in cloud.point_format.dimension_names if not np.array_equal(cloud[name][place[rows]], new[name])]
    crs = [v.string for v in new.header.vlrs if isinstance(v, laspy.vlrs.known.WktCoordinateSystemVlr)]
    return rows, [*names, *([] if crs == [CRS] else ["the coordinate reference system"])]


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--format", choices=("laz", "copc.laz", "e57"), default="laz")
    parser.add_argument("--points", type=int, default=20_000_000)
    parser.add_argument("--kills", type=int, default=2)
    options = parser.parse_args()
    scan = options.folder / f"survey.{options.format}"
    whole, resumed = (options.folder / name for name in ("whole.laz", "resumed.laz"))
    points, flying = survey(options.points)
    if options.format == "e57":
        write_e57(scan, points)
    elif options.format == "copc.laz":
        write_copc(scan, lidar(points))
        with laspy.CopcReader.open(scan) as reader:
            assert len(reader.query()) == len(points)
    else:
        lidar(points).write(scan)
    del points
    start = time.perf_counter()
    subprocess.run(command(scan, whole), check=True)
    seconds = time.perf_counter() - start
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"whole: {seconds:.0f} s, {spent.ru_utime + spent.ru_stime:.0f} s of processors, {spent.ru_maxrss / 1e3:.0f} MB a process"
    )
    for kill in range(options.kills):
        process = subprocess.Popen(command(scan, resumed), start_new_session=True)
        try:
            process.wait(seconds * (kill + 1) / (options.kills + 2))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            time.sleep(10)  # its workers end by themselves
    subprocess.run(command(scan, resumed), check=True)
    print("same bytes:", whole.read_bytes() == resumed.read_bytes())
    rows, bad = differences(scan, whole)
    print(f"left: {len(rows):,} of {len(flying):,} points, {flying[rows].sum():,} of {flying.sum():,} flyers")
    print("not as before:", bad or "nothing")
    return 0


if __name__ == "__main__":
    sys.exit(main())
