"""How depth maps are denoised, whose noise neighbours share: strongly, for as many rounds as suit the surface."""

from collections.abc import Iterator
from dataclasses import replace

from ..evidence import Choice, choose_by_risk, far_from_border, noise_field, sample_of
from ..execution import Progress, ignore_progress
from ..mesh import Floats, Ints, NormalisedMesh, normalised_mesh
from ..topology import BorderPolicy
from .candidates import results_after
from .noise_level import smooth_normals
from .repertoire import AutomaticParameters, Setting
from .shared_noise import RINGS, in_steps, on_lines_of_sight
from .surroundings import Surroundings

_STRONG = AutomaticParameters("averaged", "gaussian", 0.4, 0.0, 2.5, "two_ring", 20, 40)
#: Strong, and fixed: what suits most maps of structured light.
RANGE_MAP = Setting(parameters=_STRONG)
#: The rounds among which is chosen.
ROUNDS = (1, 2, 3, 5, 7, 10, 14, 20, 28, 40)

# Noise of single vertices, and noise smoothed over so many steps, as seen by differences of so many.
_WIDTHS, _SCALES = (0, 1, 2, 4, 8), (1, 2, 4, 8)
# Maps of more faces are judged by so many patches, each wide enough for forty rounds.
_WHOLE, _PATCHES, _FACES = 60_000, 10, 6_000


def range_map_setting(
    mesh: NormalisedMesh, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> tuple[Setting, Choice[Setting] | None]:
    """How to denoise a mesh with noise that neighbours share, and what speaks for it.

    The noise of a time-of-flight camera is known well enough where its map is calm: that number of rounds is taken whose slopes
    are nearest to the truth by `choose_by_risk`. Where depths are rounded noise is shared as widely as the steps are, and in
    fused maps more widely than can be told from the surface: these get `RANGE_MAP`.

    Args:
        mesh: the mesh; vertices that may not move are no evidence.
        border: see `normal_filtering`.
        progress: called with the share that is done; may raise to stop.
    """
    if in_steps(mesh.points, mesh.cells) or not on_lines_of_sight(mesh.points, mesh.cells):
        return RANGE_MAP, None
    sample = sample_of(mesh.points, mesh.cells, whole=_WHOLE, patches=_PATCHES, size=_FACES)
    points, faces = sample.points, sample.faces
    normals, scored = smooth_normals(points, faces), far_from_border(faces, len(points), rings=RINGS)
    movable = None if mesh.movable is None else mesh.movable[sample.origin]
    scored = scored if movable is None else scored & movable
    known = Surroundings.of(normalised_mesh(points, faces), ends=len(mesh.cells) <= _WHOLE)

    def candidates(start: Floats, held: Ints) -> list[Iterator[Floats]]:
        return [iter([start]), results_after(start, faces, known, (_STRONG, ROUNDS), border=border, movable=movable)]

    noise = noise_field(points, faces, normals=normals, scored=scored, widths=_WIDTHS, scales=_SCALES)
    labels = [[Setting()], [Setting(parameters=replace(_STRONG, outer_iterations=rounds)) for rounds in ROUNDS]]
    found = choose_by_risk(
        points, faces, candidates, labels, normals=normals, scored=scored, noise=noise.heights, progress=progress
    )
    return (RANGE_MAP, None) if found is None else (found.chosen.label, found)
