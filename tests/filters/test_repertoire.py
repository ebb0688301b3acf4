"""What denoising chooses from, and what is left of it where something is given."""

import numpy as np
import pytest

from pymeshfair.filters.denoising import REPERTOIRE, RelaxationDirection, Scan, Setting, SettingsTried
from pymeshfair.filters.denoising.scan import NONE_HELD
from pymeshfair.filters.mesh import normalised_mesh
from tests.meshes import icosphere, noisy


def test_the_first_setting_is_to_do_nothing() -> None:
    """So it stays where parameters are given."""
    for given in ({}, {"range_sigma": 0.3}, {"relaxation": 5}, {"outer_iterations": 0}):
        tried = SettingsTried(Scan.of(*icosphere(1)), border="along", of=REPERTOIRE.narrowed(**given))
        assert tried.labels[0][0] == Setting()


def test_nothing_given_narrows_nothing() -> None:
    """The whole repertoire is left."""
    assert REPERTOIRE.narrowed() == REPERTOIRE


def test_a_parameter_of_the_filter_is_in_all_chains() -> None:
    """Chains that differ in nothing else become one, with the stops of both."""
    left = REPERTOIRE.narrowed(range_sigma=0.2)
    assert {parameters.range_sigma for parameters, _ in left.chains} == {0.2}
    assert len({parameters for parameters, _ in left.chains}) == len(left.chains) == len(REPERTOIRE.chains) - 3
    assert left.taubin == (0,)
    wide, narrow = REPERTOIRE.chains[2][0], REPERTOIRE.chains[3][0]
    two = REPERTOIRE._replace(chains=((wide, (4, 10, 20)), (narrow, (2, 4, 8, 14))))
    assert [stops for _, stops in two.narrowed(range_sigma=0.2).chains] == [(2, 4, 8, 10, 14, 20)]


def test_given_rounds_are_the_only_stop() -> None:
    """None of them leaves Taubin's steps alone."""
    assert {stops for _, stops in REPERTOIRE.narrowed(outer_iterations=7).chains} == {(7,)}
    none = REPERTOIRE.narrowed(outer_iterations=0)
    assert none.chains == ()
    assert none.taubin == REPERTOIRE.taubin


def test_given_steps_come_before_every_chain() -> None:
    """And are tried alone, beside nothing."""
    left = REPERTOIRE.narrowed(relaxation=5, relaxation_direction="normal")
    assert (left.taubin, left.relaxations) == ((0, 5), (5,))
    assert left.chains == REPERTOIRE.chains
    assert left.relaxation_direction == "normal"
    assert REPERTOIRE.narrowed(relaxation=0).taubin == (0,)


@pytest.mark.parametrize("direction", ["all", "normal"])
def test_steps_alone_are_tried_in_the_given_direction(direction: RelaxationDirection) -> None:
    """What is tried is what the chosen setting does: eight steps along the normals, or in all directions."""
    vertices, faces = noisy(icosphere(2), 0.05)
    mesh = normalised_mesh(vertices, faces)
    left = REPERTOIRE.narrowed(relaxation_direction=direction)
    tried = SettingsTried(Scan.of(mesh.points, mesh.cells), border="along", of=left)
    results = list(tried(mesh.points, NONE_HELD)[0])
    at = [setting.relaxation for setting in tried.labels[0]].index(8)
    assert tried.labels[0][at] == Setting(8, direction)
    np.testing.assert_allclose(results[at], tried.labels[0][at].apply(mesh.points, mesh.cells), atol=1e-12)
