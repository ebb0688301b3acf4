"""A lidar survey from LAZ to LAZ by tiles, killed and resumed: ``python benchmarks/survey.py FOLDER [--points N] [--kills N]``.

Writes terrain with flyers as LAZ 1.4 of point format 6, with a coordinate reference system and a dimension of its own; cleans it
by ``run clean_point_cloud --tiles --memory 1GB``, once to the end, and once killed (kill -9) and resumed. Prints times, memory,
whether both outputs have the same bytes, and what is not as it was in the points that are left.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path

import laspy
import numpy as np
from cloud_strays import terrain

#: a point every half metre or so, and so many in a sheet of terrain
SPACING, SHEET = 0.5, 1_000_000
CRS = (
    'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",DATUM["European_Terrestrial_Reference_System_1989",SPHEROID["GRS 1980",'
    '6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","25832"]]'
)


def write_survey(path: Path, count: int) -> None:
    """Sheets of terrain side by side, with the density of a survey, and all that a scanner says of a point."""
    sheets = max(1, count // SHEET)
    each, columns = count // sheets, int(np.ceil(sheets**0.5))
    side, parts = SPACING * each**0.5, []
    for number in range(sheets):
        sheet = np.concatenate(terrain(each, side=side, seed=number))
        parts.append(np.add(sheet, [side * (number % columns), side * (number // columns), 0.0]))
    random = np.random.default_rng(2)
    points = np.add(random.permutation(np.concatenate(parts)), [5e5, 5.4e6, 300.0])
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = [1e-3] * 3, [5e5, 5.4e6, 0.0]
    header.add_extra_dim(laspy.ExtraBytesParams("amplitude", "uint16"))
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(CRS))
    header.global_encoding.wkt = True
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T
    for name, most in (("intensity", 60000), ("classification", 20), ("return_number", 5), ("amplitude", 9999)):
        cloud[name] = random.integers(0, most, len(points))
    cloud.gps_time = np.arange(len(points)) / 7e4
    cloud.write(path)


def command(scan: Path, output: Path, *more: str) -> list[str]:
    """The run by tiles."""
    own = (sys.executable, "-m", "pymeshfair", "run", "clean_point_cloud", str(scan), "-o", str(output))
    return [*own, "--tiles", "--memory", "1GB", "--resume", *more]


def differences(before: Path, after: Path) -> list[str]:
    """What the points that are left have not as it was, by the times at which they were measured."""
    old, new = laspy.read(before), laspy.read(after)
    rows = np.rint(np.asarray(new.gps_time) * 7e4).astype(np.int64)
    names = [name for name in old.point_format.dimension_names if not np.array_equal(old[name][rows], new[name])]
    crs = [v.string for v in new.header.vlrs if isinstance(v, laspy.vlrs.known.WktCoordinateSystemVlr)]
    return [*names, *([] if crs == [CRS] else ["the coordinate reference system"])]


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--points", type=int, default=20_000_000)
    parser.add_argument("--kills", type=int, default=2)
    options = parser.parse_args()
    scan, whole, resumed = (options.folder / name for name in ("survey.laz", "whole.laz", "resumed.laz"))
    write_survey(scan, options.points)
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
    print("not as before:", differences(scan, whole) or "nothing")
    return 0


if __name__ == "__main__":
    sys.exit(main())
