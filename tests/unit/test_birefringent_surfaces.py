"""What `gem_dielectric` holds of a birefringent material: tables by direction, and its optic frame."""

from __future__ import annotations

import mitsuba as mi
import numpy as np
import pytest
from physics_tolerances import COORDINATE, SINGLE

from gemrender import InputError
from gemrender.optics import load_material
from gemrender.optics.principal import along_axes

GRID = np.clip(np.arange(360.0, 831.0), 380.0, 760.0)


@pytest.fixture
def surface(variant_llvm_ad_spectral):
    def make(material="sapphire", **parameters):
        return mi.load_dict({"type": "gem_dielectric", "material": material, **parameters})

    return make


@pytest.mark.parametrize("material", ["sapphire", "tanzanite"])
def test_tables_hold_the_principal_indices(surface, material):
    made = surface(material, ext_ior=1.3)
    expected = along_axes(load_material(material).crystal, GRID) / 1.3
    assert made.birefringent
    assert (made.principal_tables.dtype, made.principal_tables.shape) == (np.float32, (3, 471))
    np.testing.assert_allclose(made.principal_tables, expected, rtol=SINGLE)


@pytest.mark.parametrize("material", ["ruby", "tanzanite"])
def test_tables_hold_the_absorption_of_each_direction(surface, material):
    made = surface(material, unit_mm=2.5)
    expected = 2.5 * load_material(material).crystal.principal_absorption_per_mm(GRID).T
    assert made.absorption_tables.dtype == np.float32
    np.testing.assert_allclose(made.absorption_tables, expected, rtol=SINGLE, atol=1e-30)


def test_a_crystal_that_absorbs_alike_does_so_in_all_directions(surface, tmp_path):
    index = 'formula = "cauchy"\ncoefficients = [{}]\nrange_nm = [360, 830]\n'
    path = tmp_path / "alike.toml"
    path.write_text(
        f"[index]\n{index.format(1.6)}[index_e]\n{index.format(1.7)}"
        "[absorption]\nwavelength_nm = [360, 830]\nper_mm = [0.2, 0.4]\n"
    )
    made = surface(str(path))
    np.testing.assert_array_equal(made.absorption_tables, np.tile(made.absorption_table, (3, 1)))
    assert made.absorbs


def test_without_dispersion_the_indices_are_those_of_the_sodium_line(surface):
    made = surface("moissanite", dispersion=False)
    n_o, n_e = load_material("moissanite").crystal.principal_indices(589.3)
    np.testing.assert_allclose(made.principal_tables, [[n_o] * 471, [n_o] * 471, [n_e] * 471], rtol=SINGLE)


@pytest.mark.parametrize("material", ["diamond", "sapphire", "tanzanite"])
def test_the_isotropic_twin_has_the_same_in_all_directions(surface, material):
    twin = surface(material, birefringence=False)
    assert not twin.birefringent
    np.testing.assert_array_equal(twin.principal_tables, np.tile(twin.index_table, (3, 1)))
    np.testing.assert_array_equal(twin.absorption_tables, np.tile(twin.absorption_table, (3, 1)))
    split = surface(material)
    np.testing.assert_array_equal(split.index_table, twin.index_table)
    np.testing.assert_array_equal(split.absorption_table, twin.absorption_table)


def test_isotropic_materials_split_nothing(surface, variant_llvm_ad_spectral):
    assert not surface("diamond").birefringent
    assert not mi.load_dict({"type": "gem_dielectric", "int_ior": 1.7}).birefringent


def test_the_optic_frame_is_that_of_the_axes(surface):
    axes = surface("tanzanite", c_axis=[0, 0, 3], a_axis=[0, -2, 0]).crystal_axes
    assert axes.dtype == np.float64
    np.testing.assert_allclose(axes, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], rtol=0, atol=COORDINATE)


@pytest.mark.parametrize("c_axis", [[0, 0, 1], [1, 0, 0], [0.3, -2.0, 0.5], [1, 1, 1]])
def test_the_optic_frame_is_right_handed_about_any_axis(surface, c_axis):
    axes = surface(c_axis=c_axis).crystal_axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes[2], np.array(c_axis) / np.linalg.norm(c_axis), rtol=0, atol=COORDINATE)


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"c_axis": [0, 0, 0]}, "c_axis = .*: must be a vector that is not 0"),
        ({"a_axis": [0, 0, 0]}, "a_axis = .*: must be a vector that is not 0"),
        ({"c_axis": [0, 0, float("nan")]}, "c_axis = .*: must be a vector that is not 0"),
        ({"a_axis": [1, 0, 1]}, "a_axis = .*: must be at right angles to c_axis, and is 45 degrees off"),
        ({"birefringence": 1}, "birefringence = 1: must be true or false"),
    ],
)
def test_wrong_parameters_are_refused(surface, parameters, told):
    with pytest.raises((InputError, RuntimeError), match=told):
        surface(**parameters)


def test_the_surface_says_whether_it_splits_light(surface):
    assert "birefringence = True" in str(surface())
