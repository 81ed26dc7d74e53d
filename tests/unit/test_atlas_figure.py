"""Maps of atlases: what they are of, where they jump, what is drawn on them."""

from __future__ import annotations

import textwrap

import numpy as np
import pytest

import gemrender as gem
from gemrender.errors import InputError
from gemrender.report.atlas import EXCELLENT, atlas_figure
from gemrender.sweep.atlas.map import atlas_map, cliffs, parameter_of, two_mains_limit
from gemrender.sweep.atlas.plan_file import read_plan
from gemrender.sweep.atlas.store import DONE, NO_STONE, AtlasStore, open_atlas

GRID = """
    name = "Made up"
    stone = "gia-excellent"
    measures = "inoue,window"
    chunk = 1000
    [vary]
    crown_angle = "30:38:1"
    table = [60, 55, 50]
    pavilion_angle = "40:42:0.5"
    material = ["diamond", "sapphire"]
    """
DESIGN = """
    stone = "gia-excellent"
    chunk = 1000
    [vary]
    crown_angle = "30:38"
    pavilion_angle = "40:42"
    table = "50:60"
    [sobol]
    number = 256
    """


@pytest.fixture
def atlas(tmp_path):
    """Return what makes an atlas whose values are a function of the parameters."""

    def make(text, value, name="window"):
        path = tmp_path / "plan.toml"
        path.write_text(textwrap.dedent(text))
        plan = read_plan(path)
        store = AtlasStore(plan, str(tmp_path / "a.zarr"))
        settings = list(plan.settings(plan.place(0)))
        values = np.array([value(setting) for setting in settings]).reshape(plan.shape)
        found = {of.name: np.where(of.key, values, 0.01) for of in plan.variables}
        found |= {key: np.array([setting[key] for setting in settings]) for key in plan.ranges}
        store.write(0, found | {"status": np.where(np.isnan(values), NO_STONE, DONE)})
        return open_atlas(str(tmp_path / "a.zarr"))

    return make


def test_a_map_has_the_values_at_what_is_fixed_in_increasing_order(atlas):
    made = atlas(GRID, lambda s: s["table"] + 100 * s["crown_angle"] + 1e4 * (s["material"] == "sapphire"))
    with made:
        shown = atlas_map(made, "table", "crown_angle", "window", {"material": "sapphire"})
    assert shown.at_x.tolist() == [50, 55, 60]
    np.testing.assert_array_equal(shown.values, 1e4 + 100 * shown.at_y[:, None] + shown.at_x)
    assert shown.fixed == {"pavilion_angle": 41.0, "material": "sapphire"}


def test_names_of_measures_are_understood(atlas):
    with atlas(GRID, lambda s: 1.0) as made:
        shown = [
            atlas_map(made, None, None, name, {}).measure for name in (None, "inoue", "inoue.rear", "window")
        ]
        assert shown == ["inoue_average", "inoue_average", "inoue_rear", "window"]


@pytest.mark.parametrize(
    ("x", "y", "measure", "at", "said"),
    [
        ("tabel", None, None, {}, "must be one of crown_angle, table, pavilion_angle; did you mean table"),
        ("material", None, None, {}, "--x = 'material': must be one of"),
        ("table", "table", None, {}, "--y = 'table': is the other axis"),
        (None, None, "iso", {}, "--measure = 'iso': must be one of inoue_average"),
        (None, None, None, {"star": "50"}, "cannot be fixed; must be one of pavilion_angle, material"),
        (None, None, None, {"table": "50"}, "--at = 'table': is an axis of the map"),
        (None, None, None, {"pavilion_angle": "50"}, "must be a number from 40 to 42"),
        (None, None, None, {"material": "ruby"}, "must be one of diamond, sapphire"),
    ],
)  # fmt: skip
def test_what_is_not_in_the_atlas_is_told(atlas, x, y, measure, at, said):
    with atlas(GRID, lambda s: 1.0) as made, pytest.raises(InputError) as caught:
        atlas_map(made, x, y, measure, at)
    assert said in str(caught.value)


def test_a_design_is_averaged_over_what_is_not_shown(atlas):
    """Of a sum of linear functions the mean over a parameter is its middle, nearly."""
    with atlas(DESIGN, lambda s: s["crown_angle"] + 10 * s["pavilion_angle"] + 0.01 * s["table"]) as made:
        shown = atlas_map(made, "crown_angle", "pavilion_angle", "inoue", {})
    assert shown.averaged == ("table",)
    assert shown.values.shape == (4, 4)
    expected = shown.at_x + 10 * shown.at_y[:, None] + 0.01 * 55
    within_a_cell = 0.5 * (8 / 4 + 10 * 2 / 4) / 4  # means of 16 points that fill it
    np.testing.assert_allclose(shown.values, expected, atol=within_a_cell)


# ---- Cliffs --------------------------------------------------------------------------------------------


def test_a_jump_is_a_cliff_and_a_bend_is_none():
    at = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0])  # uneven
    smooth = 3.0 * (at - 2.2) ** 2
    none = np.zeros(6)
    assert not cliffs(at, smooth, none).any()
    assert not cliffs(at, 2.0 * at, none).any()
    np.testing.assert_array_equal(
        cliffs(at, 2.0 * at + 9.0 * (at > 2), none), [False, False, True, False, False, False][:5]
    )


@pytest.mark.parametrize("middle", [-3.0, 0.1, 2.45, 5.0, 9.0])
def test_smooth_values_have_no_cliff_wherever_they_turn(middle):
    at = np.arange(8.0)
    for values in (
        (at - middle) ** 2,
        (at - middle) ** 3,
        np.exp(0.7 * (at - middle)),
        np.sin(0.5 * (at - middle)),
    ):
        assert not cliffs(at, values, np.zeros(8)).any()


def test_a_peak_of_one_cell_is_two_cliffs():
    values = np.array([4.1, 4.2, 4.3, 11.2, 6.1, 6.7, 6.3, 6.4])
    assert cliffs(np.arange(8.0), values, np.full(8, 0.2)).tolist() == [False, False, True, True] + 3 * [
        False
    ]


def test_what_the_error_bounds_allow_is_no_cliff():
    at, values = np.arange(5.0), np.array([0.0, 0.0, 1.0, 1.0, 1.0])
    assert cliffs(at, values, np.full(5, 0.4)).tolist() == [False, True, False, False]
    assert not cliffs(at, values, np.full(5, 0.6)).any()


def test_where_a_side_is_missing_nothing_is_told():
    at, values = np.arange(7.0), np.array([0.0, 9.0, 9.0, np.nan, 9.0, 0.0, 0.0])
    assert not cliffs(at, values, np.zeros(7)).any()


def test_the_limit_of_two_mains_is_that_of_a_ray_followed():
    """A ray straight down, mirrored by two planes, meets the bezel at the critical angle."""
    crown, index = np.radians(34.5), 2.4173
    pavilion = np.radians(two_mains_limit(np.array(34.5), index))
    ray = np.array([0.0, -1.0])
    for side in (1, -1):
        normal = np.array([side * np.sin(pavilion), -np.cos(pavilion)])
        ray = ray - 2 * (ray @ normal) * normal
    bezel = np.array([-np.sin(crown), np.cos(crown)])
    assert np.cross([*bezel, 0], [*ray, 0])[2] ** 2 == pytest.approx(1 / index**2, rel=1e-12)


# ---- The figure ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stone", "key", "value"),
    [
        ("gia-excellent", "crown_angle", 34.0),
        ("gia-excellent", "lower_half", 80.0),
        ("tolkowsky", "table", 53.0),
    ],
)
def test_parameters_of_a_stone(stone, key, value):
    assert parameter_of(gem.load_stone(stone), key) == pytest.approx(value, rel=1e-12)


def test_the_figure_has_range_marks_and_words(atlas):
    from matplotlib.patches import Rectangle

    with atlas(GRID, lambda s: s["crown_angle"] + 9 * (s["pavilion_angle"] > 41.2)) as made:
        shown = atlas_map(made, "crown_angle", "pavilion_angle", "window", {"material": "diamond"})
        other = atlas_map(made, "crown_angle", "pavilion_angle", "window", {"material": "sapphire"})
    figure = atlas_figure(shown, [gem.load_stone("gia-excellent")])
    axes = figure.axes[0]
    frames = [part for part in axes.patches if isinstance(part, Rectangle)]
    assert [(frame.get_x(), frame.get_width()) for frame in frames] == [(31.5, pytest.approx(5.0))]
    assert frames[0].get_y() == EXCELLENT["pavilion_angle"][0]
    mark = next(line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_allclose(mark.get_xydata(), [[34.0, 40.7]])
    words = " ".join(text.get_text() for text in figure.texts).replace("\n", " ")
    assert "Made up" in words
    assert "table 55; material diamond; error bound at most 0.01 %" in words
    assert "red: steps over 3 times as steep as beside" in words
    assert "GIA" not in " ".join(text.get_text() for text in atlas_figure(other).texts)


def test_stones_that_have_no_place_are_told(atlas):
    with atlas(GRID, lambda s: 1.0) as made:
        shown = atlas_map(made, "crown_angle", "pavilion_angle", None, {})
    with pytest.raises(InputError, match="is outside the map: its pavilion angle is 43"):
        atlas_figure(shown, [gem.load_stone("inoue-1")])


def test_show_tells_an_atlas_from_a_stone(gemrender, atlas, folder):
    atlas(GRID, lambda s: s["table"]).close()
    status, _, err = gemrender(
        "show", "a.zarr", "--x", "crown_angle", "--y", "pavilion-angle", "--measure", "window", "--at",
        "table=55", "--mark", "gia-excellent", "-o", "out",
    )  # fmt: skip
    assert (status, err) == (0, "written: out/a-window-crown_angle-pavilion_angle.png\n")
    assert (folder / "out" / "a-window-crown_angle-pavilion_angle.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("inoue-1", "--x", "table"), "--x = 'table': is for atlases"),
        (("a.zarr", "--at", "0.3,0.1"), "--at = '0.3,0.1': of an atlas it must be PARAMETER=VALUE"),
        (("a.zarr", "inoue-1"), "STONE = 'inoue-1': is one too many"),
        (("a.nc",), "a.nc: is no atlas"),
    ],
)
def test_bad_arguments_of_show_are_one_line(gemrender, atlas, folder, arguments, said):
    atlas(GRID, lambda s: s["table"]).close()
    status, _, err = gemrender("show", *arguments)
    assert status == 2
    assert said in err
    assert err.count("\n") == 1
