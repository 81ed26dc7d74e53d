"""Exact scores against the reference and against Mitsuba, on many stones."""

from __future__ import annotations

import numpy as np
import pytest
from beam_help import TOLD_AREA, covered_area, gem, girdle_heavy_brilliant, owners, path_of
from exact_tolerances import (
    EDGE,
    FACET_PERCENT,
    SAME_PATH,
    SAME_PATH_FEW,
    SAME_PATH_MEASURED,
    SAMPLING_256,
    SAMPLING_1024,
    TILING_ASKED,
)
from observations import run_python
from physics_tolerances import FEW_REFLECTIONS
from solids import bent_stone
from thorough import chosen, some

from gemrender.beam import measure, trace_facets
from gemrender.crosscheck import crosscheck
from gemrender.cuts import load_stone
from gemrender.cuts.random import random_brilliant
from gemrender.engines import observe
from gemrender.observation import Model
from gemrender.reference import full_paths
from gemrender.scoring import score_pixels

#: Girdles above this [%] are nowhere so thin that crown and pavilion meet within the circle.
THICK = 3.0
#: Random stones whose tiling is looked at, and points in each.
STONES, POINTS = 200, 30


@pytest.mark.parametrize("part", some(range(10), 10))
def test01_polygons_tile_the_view_and_have_the_references_paths(part):
    """Rationale: a point of the view has one path, so it lies in one polygon, whose path is the reference's.

    Expected: areas add up to those of the facets' outlines, and to the rim's polygon; each point away from
    edges has one owner, whose facets (of a girdle cell those before the girdle) and intensity are those of
    the reference's ray.
    """
    rng = np.random.default_rng([2024, part])
    model = Model(fresnel="exact")
    looked_at = 0
    for number in range(STONES // 10):
        stone = gem(random_brilliant(rng), number)
        facets = trace_facets(stone, model=model)
        assert facets.area.sum() == pytest.approx(covered_area(facets), abs=TILING_ASKED)
        if stone.proportions.girdle_thickness > THICK:
            assert facets.area.sum() == pytest.approx(TOLD_AREA, abs=TILING_ASKED)
        radius, azimuth = 0.99 * np.sqrt(rng.random(POINTS)), 2 * np.pi * rng.random(POINTS)
        points = np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth)])
        held = owners(facets, points, EDGE)
        for ray, owner in zip(full_paths(stone, points, model=model), held, strict=True):
            if not owner:  # on an edge
                continue
            assert len(owner) == 1, f"{stone.name}: ({ray.x}, {ray.y}) lies in {len(owner)} polygons"
            path, whole = path_of(facets, owner[0])
            assert list(ray.facets[: len(path)]) == path
            if whole:
                assert len(ray.facets) == len(path)
                assert ray.rear == facets.rear_mask[owner[0]]
                assert ray.primary_intensity == pytest.approx(
                    facets.primary_intensity[owner[0]], abs=FACET_PERCENT
                )
            looked_at += 1
    assert looked_at > 0.99 * STONES / 10 * POINTS


@pytest.mark.parametrize("number", some(range(10), 3))
def test02_the_stated_bound_holds_on_girdle_heavy_stones(number):
    """Rationale: the error near the girdle is told by the scatter of rays; it must not be told too small."""
    stone = gem(girdle_heavy_brilliant(np.random.default_rng([7, number])), number)
    stated, truth = measure(stone), measure(stone, bound=0.005, seed=2)
    assert stated.bound <= 0.05
    for ours, theirs in (
        (stated.average, truth.average),
        (stated.rear, truth.rear),
        *zip(stated.bands, truth.bands, strict=True),
    ):
        assert abs(ours - theirs) <= stated.bound + truth.bound


STONES_BY_KIND = {
    "sample 1": lambda: load_stone("inoue-1"),
    "sample 2": lambda: load_stone("inoue-2"),
    "turned": lambda: load_stone("inoue-2").rotated(17.3),
    "tilted facets": lambda: load_stone("inoue-2").tilted(0.5, np.random.default_rng(3)),
    # Turned, so that no pixel lies on a ridge.
    "bent kites": lambda: bent_stone(-0.004).rotated(17.3),
    "oval": lambda: bent_stone(-0.004, stretched=1.02).rotated(17.3),
}
OPTIONS = {
    "plain": {},
    "exact Fresnel": {"fresnel": "exact"},
    "rear by direction": {"rear": "direction"},
    "radiance": {"intensity": "radiance"},
    "tilted": {"tilt": 25.0, "tilt_azimuth": 40.0},
    "much tilted": {"tilt": 70.0, "tilt_azimuth": -10.0, "rear": "direction"},
}


#: Each stone, and each of the options, with one of the others; all pairs are slow.
PAIRS = [(kind, options) for kind in STONES_BY_KIND for options in OPTIONS]
FEW_PAIRS = [
    (kind, options)
    for i, kind in enumerate(STONES_BY_KIND)
    for j, options in enumerate(OPTIONS)
    if (j - i) % len(OPTIONS) == 3
]


@pytest.mark.parametrize(("kind", "options"), chosen(PAIRS, FEW_PAIRS))
def test03_maps_and_scores_are_the_references(kind, options):
    """Rationale: whatever the other engines offer, the exact one gives as well, by rays and in the mean."""
    stone = STONES_BY_KIND[kind]()
    exact, truth = (
        observe(stone, engine=engine, resolution=128, bound=0.2, **OPTIONS[options])
        for engine in ("exact", "reference")
    )
    few = np.maximum(exact.reflections, truth.reflections) <= FEW_REFLECTIONS
    same = (exact.status == truth.status) & (exact.path_code == truth.path_code)
    assert 100 * same[few].mean() >= (SAME_PATH_FEW if stone.is_round else SAME_PATH_MEASURED)
    assert crosscheck(exact, truth).same_path >= SAME_PATH
    # A map of half the side has 2^1.5 times the error.
    pixels = score_pixels(truth)
    assert exact.measured.average == pytest.approx(pixels.average, abs=2**1.5 * SAMPLING_256)
    assert exact.measured.rear == pytest.approx(pixels.rear, abs=2**1.5 * SAMPLING_256)


CONVERGED = ["inoue-1", "inoue-2", "inoue-3", "nail-head", "fish-eye"]


@pytest.mark.parametrize("name", chosen(CONVERGED, ["inoue-2", "fish-eye"]))
def test04_mitsubas_maps_converge_to_the_exact_score(name, variant_llvm_ad_mono):
    stone = load_stone(name)
    exact = measure(stone, bound=0.01)
    pixels = score_pixels(observe(stone, engine="mitsuba", resolution=1024))
    assert pixels.average == pytest.approx(exact.average, abs=SAMPLING_1024 + exact.bound)
    assert pixels.rear == pytest.approx(exact.rear, abs=SAMPLING_1024 + exact.bound)
    for band, share in zip(pixels.bands, exact.bands, strict=True):
        assert band.share == pytest.approx(share, abs=SAMPLING_1024 + exact.bound)


def test05_it_needs_no_mitsuba_and_no_llvm():
    code = (
        "import sys; from gemrender.cli.program import run; "
        "status = run(['score', 'inoue-3', '--engine', 'exact']); "
        "print(status, {'mitsuba', 'drjit'} & set(sys.modules), file=sys.stderr)"
    )
    done = run_python("-c", code, environment={"DRJIT_LIBLLVM_PATH": "/nowhere/libLLVM.so"})
    assert done.stderr == "0 set()\n"
    assert "Inoue sample 3" in done.stdout


def test06_it_works_where_its_cache_cannot_be_written(tmp_path):
    """Compiles anew, and says nothing of it."""
    (tmp_path / "file").write_text("")
    code = "from gemrender.beam.compiled import jit; print(jit(lambda x: x + 1)(1))"
    done = run_python("-c", code, environment={"NUMBA_CACHE_DIR": str(tmp_path / "file" / "cache")})
    assert (done.returncode, done.stdout) == (0, "2\n"), done.stderr
