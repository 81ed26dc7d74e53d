"""What a stone is, in figures: proportions, tiers, volume and weight, in every form."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from any_stones import FOLDER, design, facets_in, hollow_stone
from solids import star_outline, star_prism

from gemrender import cli
from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.report.inspection import (
    inspect_stone,
    inspection_records,
    inspection_tables,
    inspection_values,
)
from gemrender.report.measured import measured_dimensions
from gemrender.stone import Facet, MeshSolid, Stone, convex_solid, in_frame, side_of
from gemrender.studio.texts import dropped_stones, saved

TRUTH = json.loads((FOLDER / "truth.json").read_text(encoding="utf-8"))
#: Designs give distances with eight decimals.
FILE_ROUNDING = 1e-6
#: float64.
ROUNDING = 1e-9


def of_planes(*planes: tuple[float, float, float, float]) -> Stone:
    """Return the stone inside planes a x + b y + c z <= d, given as (a, b, c, d)."""
    given = np.array(planes)
    given /= np.linalg.norm(given[:, :3], axis=1, keepdims=True)
    framed, _ = in_frame(given)
    solid, _ = convex_solid(framed, np.arange(len(given)))
    facets = tuple(Facet(f"F{i}", f"F{i}", side_of(n[2])) for i, n in enumerate(solid.planes))
    return Stone(solid=solid, facets=facets, name="planes")


BOX = ((1, 0, 0, 1), (-1, 0, 0, 1), (0, 1, 0, 0.5), (0, -1, 0, 0.5))


def test_a_box_is_all_girdle():
    """2 by 1 and 0.4 high."""
    d = measured_dimensions(of_planes(*BOX, (0, 0, 1, 0.2), (0, 0, -1, 0.2)))
    assert d["length_to_width"].value == pytest.approx(2.0)
    assert (d["crown_height"].value, d["pavilion_depth"].value) == pytest.approx((0.0, 0.0), abs=ROUNDING)
    girdle = d["girdle_thickness"]
    assert (girdle.least, girdle.value, girdle.most) == pytest.approx((40.0, 40.0, 40.0))
    assert d["total_depth"].value == pytest.approx(40.0)
    assert d["table"].value == pytest.approx(100.0)


def test_a_wedge_has_a_girdle_from_thin_to_thick():
    """Its top rises along x from 0.1 to 0.3 above a level bottom: per cent of its width 1."""
    d = measured_dimensions(of_planes(*BOX, (-0.1, 0, 1, 0.2), (0, 0, -1, 0)))
    girdle = d["girdle_thickness"]
    assert (girdle.least, girdle.most) == pytest.approx((10.0, 30.0))
    assert girdle.value == pytest.approx(20.0)  # the mean along all four sides


def test_a_girdle_is_as_thick_however_finely_its_mesh_is_cut():
    """A prism 0.5 high over a star, each wall of 2 triangles or of 128."""
    subdivide = pytest.importorskip("trimesh").remesh.subdivide
    stone = star_prism()
    solid, percent = stone.solid, 100.0 * 0.5 / np.ptp(star_outline(), axis=0).min()
    for _ in range(4):
        girdle = measured_dimensions(replace(stone, solid=solid))["girdle_thickness"]
        assert (girdle.least, girdle.value, girdle.most) == pytest.approx((percent,) * 3)
        vertices, triangles, pieces = subdivide(solid.vertices, solid.triangles, return_index=True)
        facet = np.empty(len(triangles), dtype=np.int64)
        for triangle, numbers in pieces.items():
            facet[numbers] = solid.facet[triangle]
        solid = MeshSolid(vertices=vertices, triangles=triangles, facet=facet)


def test_a_bipyramid_has_no_girdle():
    planes = [(x, y, z, 0.5) for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)) for z in (1, -1)]
    d = measured_dimensions(of_planes(*planes))
    assert d["girdle_thickness"].most == 0.0
    assert d["crown_height"].value == pytest.approx(d["pavilion_depth"].value)
    assert "table" not in d


def test_where_girdle_facets_leave_off_it_is_a_knife_edge():
    """Crown and pavilion meet along y, and stand apart along x."""
    planes = [
        (1, 0, 0, 0.5),
        (-1, 0, 0, 0.5),
        (0, 1, 1, 0.5),
        (0, -1, 1, 0.5),
        (0, 1, -1, 0.5),
        (0, -1, -1, 0.5),
    ]
    assert measured_dimensions(of_planes(*planes))["girdle_thickness"].least == 0.0


@pytest.mark.parametrize("name", ["inoue-1", "gia-excellent"])
def test_a_round_brilliant_measures_what_it_was_made_of(name):
    """Its girdle is as thick as it was made at the vertices; between them the arcs leave less."""
    stone = load_stone(name)
    d, p = measured_dimensions(stone), stone.proportions
    for key in ("table", "crown_height", "pavilion_depth"):
        assert d[key].value == pytest.approx(getattr(p, key)), key
    assert d["girdle_thickness"].most == pytest.approx(p.girdle_thickness)
    assert d["girdle_thickness"].least < d["girdle_thickness"].value < p.girdle_thickness


@pytest.mark.parametrize("name", ["emerald", "pear", "oval", "heart", "triangle-negative-gear"])
def test_designs_measure_what_is_known_of_them(name):
    """Volume and depth of an independent program, in radii of the outline."""
    stone, truth = design(name), TRUTH[name]["solid"]
    found = inspect_stone(stone)
    unit = in_frame(stone.cut.planes())[1]
    radius = 1.0 / (truth["scale_from_file_units"] * unit)
    assert found.volume == pytest.approx(truth["volume"] * radius**3, rel=FILE_ROUNDING)
    assert found.dimensions["length_to_width"].value == pytest.approx(
        truth["length_over_width_box"], rel=FILE_ROUNDING
    )
    depth = found.depth_mm / (found.length_mm / 2)
    assert depth == pytest.approx(truth["depth"] * radius, rel=FILE_ROUNDING)
    sides = [tier.side for tier in found.tiers for _ in range(tier.number)]
    assert {side: sides.count(side) for side in ("crown", "girdle", "pavilion")} == {
        side: truth[side] for side in ("crown", "girdle", "pavilion")
    }


def test_tiers_are_those_of_the_file():
    found = inspect_stone(design("emerald"))
    assert sum(tier.area for tier in found.tiers) == pytest.approx(100.0)
    tier = next(tier for tier in found.tiers if tier.name == "P8")
    assert (tier.side, tier.number, tier.indices) == ("pavilion", 4, (36.0, 12.0, 60.0, 84.0))
    assert tier.angle_deg == pytest.approx(47.0)
    assert [tier.side for tier in found.tiers] == sorted(
        (tier.side for tier in found.tiers), key=["crown", "girdle", "pavilion"].index
    )


def test_a_round_girdle_in_facets_does_not_list_every_tooth():
    (of,) = dropped_stones("round.asc", saved(load_stone("quartz-round"), "asc"))
    rows = [row for table in inspection_tables([inspect_stone(of)]) for row in table.rows]
    (girdle,) = (row for row in rows if row[:2] == ["girdle", "girdle"])
    assert girdle[-1] == "1 to 96"


def test_tilted_facets_have_a_range_of_angles():
    stone = load_stone("inoue-1").tilted(0.5, np.random.default_rng(3))
    mains = next(tier for tier in inspect_stone(stone).tiers if tier.name == "pavilion_main")
    assert mains.least_angle_deg < mains.angle_deg < mains.most_angle_deg
    assert mains.indices is None


def test_weight_is_volume_times_density():
    """A brilliant of 6.5 mm in diamond, 3.52 g/cm3: a carat is 200 mg."""
    stone = load_stone("inoue-3")
    found = inspect_stone(stone, size_mm=6.5)
    assert found.carat == pytest.approx(stone.solid.volume * 3.25**3 * 3.52 / 200)
    assert 0.95 < found.carat < 1.05, "a carat, as everyone knows"
    assert inspect_stone(stone, size_mm=13.0).carat == pytest.approx(8 * found.carat)
    assert inspect_stone(design("pear")).carat is None


def test_a_stone_that_is_not_convex_is_measured_too():
    found, whole = inspect_stone(hollow_stone()), inspect_stone(design("emerald"))
    assert found.cut == "mesh"
    assert found.dimensions["girdle_thickness"].value == pytest.approx(
        whole.dimensions["girdle_thickness"].value
    )
    table = next(tier for tier in whole.tiers if tier.name == "T")
    surface = design("emerald").solid.areas.sum()
    pit = 0.1 * surface * table.area / 100 / 3  # a pyramid below the table
    assert whole.volume - found.volume == pytest.approx(pit)


def test_single_precision_leaves_the_girdle_as_thick():
    """A mesh as STL has it: corners moved by 3e-8, and facets that nearly meet."""
    stone = hollow_stone()
    vertices = stone.solid.vertices.astype(np.float32).astype(np.float64)
    solid = replace(stone.solid, vertices=vertices)
    girdle = measured_dimensions(replace(stone, solid=solid))["girdle_thickness"]
    known = measured_dimensions(stone)["girdle_thickness"]
    assert girdle.value == pytest.approx(known.value, abs=1e-3)
    assert girdle.least == pytest.approx(known.least, abs=1e-3)


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan"), 1e9])
def test_sizes_that_no_stone_has_are_refused(size):
    with pytest.raises(InputError, match=r"^size = .*: must be from 0.1 to 1000 \[mm\]$"):
        inspect_stone(load_stone("inoue-1"), size_mm=size)


# ---- Forms ---------------------------------------------------------------------------------------------


def test_values_and_records_say_the_same():
    found = inspect_stone(design("pear"))
    values = json.loads(json.dumps(inspection_values(found)))
    records = inspection_records(found)
    tiers = facets_in("pear")
    assert sorted(record["number"] for record in records) == sorted(tiers)
    assert len(values["tiers"]) == len(tiers)
    assert values["proportions"]["girdle_thinnest"] <= values["proportions"]["girdle_thickest"]
    for record, tier in zip(records, values["tiers"], strict=True):
        assert record["tier"] == tier["name"]
        assert record["number"] == tier["number"]
        assert record["facets"] == sum(tiers)
        assert record["total_depth"] == values["proportions"]["total_depth"]


def test_the_table_says_what_was_mended_and_assumed():
    noted = replace(design("pear"), name="noted", notes=("was mended",), assumed=("half of it",))
    notes = [note.text for table in inspection_tables([inspect_stone(noted)]) for note in table.notes]
    assert {"noted: was mended.", "noted: taken: half of it."} <= set(notes)


def test_the_command_prints_each_form(capsys):
    path = str(FOLDER / "emerald.asc")
    for form, start in (("table", ""), ("json", "[\n"), ("csv", "name,tier,side,"), ("markdown", "|")):
        with pytest.raises(SystemExit) as caught:
            cli.main(["inspect", path, "--size", "8", "--material", "quartz", "--format", form])
        printed = capsys.readouterr()
        assert caught.value.code == 0, printed.err
        assert printed.out.startswith(start)
        if form == "json":
            [values] = json.loads(printed.out)
            assert values["length_mm"] == 8.0
            assert values["carat"] > 0
            assert values["tiers"][0]["indices"] == [96.0]
