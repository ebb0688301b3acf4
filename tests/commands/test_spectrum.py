"""`pymeshfair spectrum` tells, prints and draws how much of a shape lies at which wavelength."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair.filters.spectral.problem import low_pass
from pymeshfair.filters.spectral.spectrum import spectrum
from tests.meshes import Mesh, icosphere, noisy

from .command_line import document, invoke


def saved(path: Path, mesh: Mesh) -> Path:
    """The mesh as a file."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh))
    meshes.save_current_mesh(str(path))
    return path


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sphere with noise, in double precision."""
    return saved(tmp_path_factory.mktemp("scans") / "sphere.ply", noisy(icosphere(3), 0.01))


def test_the_document_holds_the_spectrum(scan: Path) -> None:
    """The numbers are those of the function; the file is not changed and nothing is written beside it."""
    before, beside = scan.read_bytes(), set(scan.parent.iterdir())
    read = document(invoke("spectrum", scan, "--modes", "12", "--json").stdout)
    found = spectrum(*noisy(icosphere(3), 0.01), modes=12)
    np.testing.assert_allclose(read["before"]["band_energies"], found.band_energies, rtol=1e-4)
    np.testing.assert_allclose(read["before"]["frequencies"], found.frequencies, rtol=1e-4)
    assert (read["response"], read["picture"]) == (None, None)
    assert "after" not in read
    assert (scan.read_bytes(), set(scan.parent.iterdir())) == (before, beside)


def test_the_table_has_a_row_for_each_band(scan: Path) -> None:
    """Wavelengths fall from row to row; the largest height is that of the sphere."""
    done = invoke("spectrum", scan, "--modes", "0")
    assert done.exit_code == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if line[:1] in " 0123456789" and line.strip()]
    lengths, heights = ([float(row[k]) for row in rows if row[0][0].isdigit()] for k in (0, 2))
    assert lengths == sorted(lengths, reverse=True)
    assert max(heights) == pytest.approx(1.0, rel=0.01)
    assert "height: the root mean square" in done.stderr


def test_a_response_is_told_with_what_it_leaves(scan: Path) -> None:
    """F(omega) at every band, and energies that fall by its square."""
    read = document(invoke("spectrum", scan, "--response", "low_pass", "--detail-size", "0.8", "--json").stdout)
    expected = low_pass(0.8)
    assert read["response"]["name"] == "low_pass"
    assert read["response"]["cutoff_frequencies"] == pytest.approx([2 * math.pi / 0.8])
    edges = np.asarray(read["before"]["band_edges"])
    np.testing.assert_allclose(read["response"]["bands"], expected.profile(np.sqrt(edges[:-1] * edges[1:])), rtol=1e-12)
    omega = np.asarray(read["before"]["frequencies"])
    left = np.asarray(read["before"]["energies"]) * expected.profile(omega) ** 2
    np.testing.assert_allclose(read["after"]["energies"], left, rtol=1e-9)
    before, after = (np.asarray(read[k]["band_energies"]) for k in ("before", "after"))
    assert (after <= before).all()
    assert after[-1] < 1e-3 * before[-1]


def test_lengths_of_a_response_carry_over(scan: Path) -> None:
    """A band is given in mean edges, its longest wave is four times the shortest unless it is given."""
    read = document(invoke("spectrum", scan, "--response", "enhance", "--detail-size", "6edge", "--json").stdout)
    edge = read["before"]["mean_edge"]
    assert read["response"]["cutoff_frequencies"] == pytest.approx([2 * math.pi / (24 * edge), 2 * math.pi / (6 * edge)])


def test_two_meshes_are_compared(scan: Path, tmp_path: Path) -> None:
    """A second file gives the column after; bands that it lacks stay empty."""
    clean = saved(tmp_path / "clean.ply", icosphere(2))
    done = invoke("spectrum", scan, "--after", clean, "--modes", "5")
    assert done.exit_code == 0, done.stderr
    assert "height before" in done.stdout
    assert "height after" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("extension", [".png", ".svg", ".pdf"])
def test_the_picture_is_drawn_whole(scan: Path, tmp_path: Path, extension: str) -> None:
    """A file of the format that its extension says, the same to the byte when it is drawn again, and nothing else."""
    begins = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[extension]
    picture = tmp_path / f"spectrum{extension}"
    contents = []
    for _ in range(2 if extension == ".png" else 1):
        done = invoke("spectrum", scan, "-o", picture, "--response", "band_pass", "--modes", "5", "--overwrite")
        assert done.exit_code == 0, done.stderr
        contents.append(picture.read_bytes())
    assert contents[0].startswith(begins)
    assert contents[0] == contents[-1]
    assert list(tmp_path.iterdir()) == [picture]


@pytest.mark.parametrize(
    ("arguments", "message", "code"),
    [
        (["-o", "spectrum.ply"], "name a file that ends with .png, .svg, .pdf", 1),
        (["-o", "no_such_folder/spectrum.png"], "does not exist; make it first", 1),
        (["--response", "lowpass"], "did you mean 'low_pass'?", 2),
        (["--response", "enhance", "--detail-size", "six edges"], "is no length", 2),
        (["--response", "enhance", "--detail-size", "1", "--largest-size", "0.5"], "is not above detail_size", 2),
        (["--response", "low_pass", "--detail-size", "0"], "detail_size 0", 2),
        (["--detail-size", "bar"], "give --response too", 2),
        (["--modes", "-1"], "--modes", 2),
    ],
)
def test_wrong_usage_is_told(scan: Path, arguments: list[str], message: str, code: int) -> None:
    """The message names what was wrong."""
    done = invoke("spectrum", scan, *arguments)
    assert message in done.stderr
    assert done.exit_code == code


def test_a_point_cloud_is_a_failed_run(tmp_path: Path) -> None:
    """A spectrum is one of a surface."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(icosphere(1)[0]))
    meshes.save_current_mesh(str(tmp_path / "cloud.ply"))
    done = invoke("spectrum", tmp_path / "cloud.ply")
    assert done.exit_code == 1
    assert "faces" in done.stderr
