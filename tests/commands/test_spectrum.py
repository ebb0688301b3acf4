"""`pymeshfair spectrum` tells, prints and draws how much of a shape lies at which wavelength."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

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
    assert read["picture"] is None
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
    for _ in range(2):
        done = invoke("spectrum", scan, "-o", picture, "--modes", "5", "--overwrite")
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
