"""All light by polygons and single rays: the columns of their paths, and that none of it is lost."""

from __future__ import annotations

import numpy as np
import pytest
from designs_help import level, ring, stone_of

import gemrender
from gemrender.beam import measure, trace_facets
from gemrender.measures import Measure, chosen_measures
from gemrender.observation import Model, RayStatus, View
from gemrender.optics.fresnel import reflectance

#: Rounding of sums over a view.
ROUNDING = 1e-9
#: Follow polygons down to this share of the view.
LEAST = 1e-5
TILTED = View(resolution=1, tilt_deg=25, tilt_azimuth_deg=40)


def exact(stone: gemrender.Stone) -> Model:
    return Model.of(stone, fresnel="exact")


def slab() -> gemrender.Stone:
    """A plate so thin that nearly nothing meets its sides."""
    return stone_of(np.concatenate([ring(4, 90, 1.0), level(1e-4), level(1e-4, down=True)]), material=1.6)


def test_a_plate_lets_through_the_series_of_its_reflections():
    """T^2 sum R^2k downwards, and R T^2 sum R^2k back up: Airy's sums without interference."""
    r = float(reflectance(np.array(1.0), 1.6))
    paths = gemrender.trace_paths(slab(), follow="all", fresnel="exact", bound=0.05)
    share = (1 - r) * paths.weight * (1 - r) * paths.area / paths.area[paths.partial_reflections == 0].sum()
    exits = paths.status == RayStatus.EXITED
    down, up = (float(share[exits & (paths.exit_direction[:, 2] * sign > 0)].sum()) for sign in (-1, 1))
    through = (1 - r) ** 2 / (1 - r**2)
    assert down == pytest.approx(through, abs=2e-5)  # what single rays tell of R^4 of the light
    assert up == pytest.approx(r * through, abs=2e-5)
    assert down + up + r == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("name", ["inoue-3", "fish-eye"])
@pytest.mark.parametrize("view", [None, TILTED], ids=["face-up", "tilted"])
def test_no_light_is_lost(name, view):
    stone = gemrender.load_stone(name)
    [aset] = measure(stone, view=view, model=exact(stone), measures=chosen_measures("aset"), bound=1).measures
    principal = sum(aset.values[key] for key in ("green", "red", "blue", "leak", "trapped"))
    weighted = [f"weighted_{key}" for key in ("green", "red", "blue", "leak")]
    everything = sum(aset.values[key] for key in (*weighted, "surface", "rest"))
    assert principal == pytest.approx(100.0, abs=ROUNDING)
    assert everything == pytest.approx(100.0, abs=ROUNDING)


def test_principal_paths_are_the_same_whatever_is_followed():
    stone = gemrender.load_stone("inoue-1")
    principal = trace_facets(stone, view=TILTED)
    of_all = trace_facets(stone, view=TILTED, least=LEAST)
    rows = of_all.paths.partial_reflections == 0
    for name in ("area", "cos_entry", "cos_exit"):
        mine, theirs = (np.sort(getattr(paths, name)) for paths in (of_all.paths.rows(rows), principal.paths))
        # Polygons are cut where they leave only; both lists hold the same ones.
        np.testing.assert_allclose(mine.sum(), theirs.sum(), rtol=1e-9)
    assert (of_all.paths.weight[rows] == 1.0).all()


def test_normals_unfold_the_stone():
    """From the eye's ray inside, the unfolded exit is met at the angle at which the path leaves."""
    stone = gemrender.load_stone("inoue-2")
    paths = gemrender.trace_paths(stone, follow="all", tilt=20.0, tilt_azimuth=10.0, bound=1.0)
    index, eye = Model.of(stone).index, View(resolution=1, tilt_deg=20.0, tilt_azimuth_deg=10.0).basis()[2]
    exits = paths.status == RayStatus.EXITED
    normal, unfolded = paths.entry_normal[exits], paths.unfolded_exit_normal[exits]
    np.testing.assert_allclose(normal @ eye, paths.cos_entry[exits], atol=1e-12)
    tangential = (-eye + (normal @ eye)[:, None] * normal) / index
    inside = tangential - np.sqrt(1.0 - (tangential**2).sum(axis=1, keepdims=True)) * normal
    cos_stone = (inside * unfolded).sum(axis=1)
    cos_air = np.sqrt(np.maximum(1.0 - index**2 * (1.0 - cos_stone**2), 0.0))
    # Near the critical angle a rounding of the one cosine is the root of one of the other.
    np.testing.assert_allclose(cos_air, paths.cos_exit[exits], atol=1e-5)


def test_a_measure_of_ones_own_has_a_bound():
    class Overhead(Measure):
        name = "overhead"

        def contributions(self, light):
            return light.share * (light.zenith_cosine > np.cos(np.pi / 6))

    score = gemrender.score(gemrender.load_stone("inoue-3"), measures=["iso", Overhead()], bound=0.1)
    iso, overhead = score.measures
    assert 0 < overhead.values["value"] < iso.values["value"]
    assert 0 < overhead.bound <= 0.1


def test_light_return_over_all_views_of_a_plate():
    """A plate's upper face gives back nothing upwards but what has been mirrored inside at its base."""
    stone = slab()
    [wlr] = measure(stone, model=exact(stone), measures=chosen_measures("wlr-like"), bound=0.2).measures
    # By elevation: T^2 R / (1 - R^2) of what falls comes back, at the angle that it fell at.
    cosine, weight = np.polynomial.legendre.leggauss(200)
    cosine, weight = 0.5 * (cosine + 1.0), 0.5 * weight
    r = reflectance(cosine, 1.6)
    returned = (1 - r) ** 2 * r / (1 - r**2)
    expected = float((weight * cosine * cosine**2 * returned).sum() / (weight * cosine).sum())
    assert wlr.values["value"] == pytest.approx(expected, abs=wlr.bound)
    assert wlr.bound <= 0.002


def test_exact_paths_are_a_table():
    paths = gemrender.trace_paths(gemrender.load_stone("inoue-3"), follow="all", bound=1.0)
    pandas = pytest.importorskip("pandas")
    table = paths.to_pandas()
    assert isinstance(table, pandas.DataFrame)
    assert len(table) == len(paths)
    assert {"area", "weight", "exit_direction_z", "set_number"} <= set(table.columns)
    assert paths.area[paths.partial_reflections == 0].sum() == pytest.approx(np.pi, abs=1e-9)
