"""The report's tracer in JavaScript against the Python reference, ray by ray."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from functools import partial
from importlib import resources

import numpy as np
import pytest
from any_stones import design, hollow_stone
from critical import INDICES, at_critical_angle
from solids import bent_stone
from thorough import chosen

from gemrender.cuts import load_stone, stone_from_vertices
from gemrender.observation import REAR_RULES, Model, RayStatus, View
from gemrender.reference import RayPath, full_paths
from gemrender.report.page import optics, traced_as, traced_solid
from gemrender.stone import Stone

#: Rays of each stone, all over its top view.
RAYS = 1000
#: Largest difference of intensities on the same path [%], of points and of directions.
SAME_PERCENT = 1e-6
SAME_PLACE = 1e-6
#: Rounding is multiplied at every reflection off the curved girdle, until two float64 tracers part: beyond
#: this number of reflections paths may differ, of at most so large a share of all rays.
FEW_REFLECTIONS = 30
LONG_SHARE = 0.005

NODE = shutil.which("node")

SCRIPT = """
const tracer = require(process.argv[1]);
require('node:readline').createInterface({ input: process.stdin }).on('line', (line) => {
    const { optics, solid, model, view, points } = JSON.parse(line);
    const surfaces = tracer.surfacesOf(solid);
    const paths = points.map(([x, y]) => {
        const path = tracer.trace(surfaces, optics, view, model, x, y);
        return { ...path, incidence: path.points.map((_, i) => tracer.anglesAt(path, i)[0]) };
    });
    process.stdout.write(JSON.stringify(paths) + '\\n');
});
"""


def measured(sigma: float, seed: int) -> Stone:
    """Return sample 2 with every vertex moved at random."""
    rng = np.random.default_rng(seed)
    vertices = load_stone("inoue-2").vertices
    return stone_from_vertices(vertices + rng.normal(0, sigma, vertices.shape), name="measured")


def tilted() -> Stone:
    """Return sample 2 with every facet tilted at random."""
    return load_stone("inoue-2").tilted(0.5, np.random.default_rng(4))


STONES = {
    "sample 1": lambda: load_stone("inoue-1"),
    "sample 2": lambda: load_stone("inoue-2"),
    "sample 3": lambda: load_stone("inoue-3"),
    "turned": lambda: load_stone("inoue-3").rotated(7.3),
    "measured": lambda: measured(0.002, 1),
    "measured badly": lambda: measured(0.008, 2),
    "tilted facets": tilted,
    "hollow": lambda: bent_stone(0.003),
    "emerald": lambda: design("emerald"),
    "pear": lambda: design("pear"),
    "slab": lambda: design("slab-chiral"),
    "hollow emerald": hollow_stone,
}


Trace = Callable[[Stone, np.ndarray, View, Model], list[dict]]


@pytest.fixture(scope="module")
def by_javascript() -> Iterator[Trace]:
    """What traces rays in node, in one process: starting one takes longer than most tests."""
    if NODE is None:
        pytest.skip("no node here; test_report_page.py traces in Chromium")
    asset = resources.files("gemrender.report").joinpath("assets/tracer.js")
    with (
        resources.as_file(asset) as file,
        subprocess.Popen(
            [NODE, "-e", SCRIPT, str(file)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as node,
    ):

        def trace(stone: Stone, points: np.ndarray, view: View, model: Model) -> list[dict]:
            request = {
                "optics": optics(),
                "solid": traced_solid(stone),
                **traced_as(model, view),
                "points": points.tolist(),
            }
            print(json.dumps(request), file=node.stdin, flush=True)
            answer = node.stdout.readline()
            assert answer, "node has ended"
            return json.loads(answer)

        yield trace


@pytest.fixture
def compare(by_javascript: Trace) -> Callable[..., None]:
    """What compares both tracers' paths of rays all over a stone."""
    return partial(compare_by, by_javascript)


def assert_same(ours: dict, theirs: RayPath) -> None:
    """Both took the same way, facet by facet, with the same numbers."""
    assert ours["facets"] == theirs.facets.tolist()
    assert ours["status"] == theirs.status
    assert ours["rear"] == theirs.rear
    assert ours["reflections"] == theirs.reflections
    assert ours["intensity"] == pytest.approx(theirs.primary_intensity, abs=SAME_PERCENT, rel=0)
    np.testing.assert_allclose(np.reshape(ours["points"], (-1, 3)), theirs.points, rtol=0, atol=SAME_PLACE)
    np.testing.assert_allclose(ours["directions"], theirs.directions, rtol=0, atol=SAME_PLACE)
    np.testing.assert_allclose(ours["incidence"], theirs.incidence_deg, rtol=0, atol=1e-4)


def compare_by(
    by_javascript: Trace,
    stone: Stone,
    *,
    view: View | None = None,
    model: Model | None = None,
    rays: int = RAYS,
) -> None:
    rng = np.random.default_rng(12345)
    view, model = view or View(resolution=1), model or Model.of(stone)
    radius, azimuth = 0.999 * np.sqrt(rng.uniform(0, 1, rays)), rng.uniform(0, 2 * np.pi, rays)
    points = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1)
    points = np.concatenate([points, [[1.2, 0.1], [0.0, -1.5]]])  # two that miss
    expected = full_paths(stone, points, view=view, model=model)
    found = by_javascript(stone, points, view, model)
    parted = 0
    for ours, theirs in zip(found, expected, strict=True):
        try:
            assert_same(ours, theirs)
        except AssertionError:
            if theirs.reflections <= FEW_REFLECTIONS:
                raise
            parted += 1
    assert parted <= LONG_SHARE * rays
    assert {theirs.status for theirs in expected} >= {RayStatus.MISSED, RayStatus.EXITED}


#: A round girdle, measured vertices, planes alone, and one that is not convex.
OF_KINDS = ["sample 2", "measured", "pear", "hollow"]


@pytest.mark.parametrize("name", chosen(STONES, OF_KINDS))
def test01_same_path_and_intensity(compare, name):
    compare(STONES[name]())


@pytest.mark.parametrize(
    "options",
    [
        {"fresnel": "exact"},
        {"intensity": "radiance"},
        {"rear": "direction"},
        {"fresnel": "exact", "index": 1.77},
        {"max_reflections": 3},
    ],
    ids=str,
)
def test02_same_for_every_model(compare, options):
    compare(load_stone("inoue-1"), model=Model(**options), rays=RAYS // 4)


def test03_same_for_a_tilted_eye(compare):
    for stone in (load_stone("inoue-3"), measured(0.002, 1), design("pear")):
        compare(stone, view=View(resolution=1, tilt_deg=25, tilt_azimuth_deg=40), rays=RAYS // 2)


def test04_edges_lose_no_ray(by_javascript):
    """Rays along symmetry planes and through vertices: nothing is lost, whichever facet they take."""
    stone = load_stone("inoue-3")
    points = np.concatenate(
        [stone.vertices[:, :2] * 0.999999999, np.linspace(-0.99, 0.99, 101)[:, None] * [1, 0]]
    )
    for path in by_javascript(stone, points, View(resolution=1), Model.of(stone)):
        assert path["status"] in (RayStatus.EXITED, RayStatus.TRAPPED)
        assert path["reflections"] + 2 == len(path["facets"]) or path["status"] == RayStatus.TRAPPED


@pytest.mark.parametrize("index", INDICES)
def test05_same_side_of_the_critical_angle(compare, index):
    """Rationale: rays meet the mains of these stones a few roundings to either side of it."""
    model = Model(index=index, fresnel="exact", max_reflections=FEW_REFLECTIONS)
    compare(at_critical_angle(index), model=model, rays=RAYS // 10)


@pytest.mark.parametrize("rear", REAR_RULES)
def test06_same_rear_light_by_every_rule(compare, rear):
    """Of a stone whose girdle's lower edge is not level, and that they tell apart."""
    compare(design("slab-chiral"), model=Model.of(design("slab-chiral"), rear=rear), rays=RAYS // 4)
