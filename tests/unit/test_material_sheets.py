"""What a material's numbers give reason to say, its sheet, and its text as a file to start from."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from glasses import ABSORBED, BY_FORMULA, BY_TABLE, PAGES, RANGE, edited, published
from physics_tolerances import ROUNDING

from gemrender import InputError, load_stone
from gemrender.errors import GemrenderWarning
from gemrender.optics import load_material, material_names, material_sheet, material_template
from gemrender.scene.setup import load_setup
from gemrender.templates import setup_template, stone_template

#: Differences of two indices of about 0.03 that are rounded at 1e-15 [relative].
DIFFERENCE = 1e-12
ABSORBED_NM = np.arange(340.0, 861.0, 0.5)


@pytest.fixture
def load(tmp_path):
    """Load a material from the text of a file, whatever there is to warn of."""

    def load_text(text, name="glass.toml"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_material(path, warn=False)

    return load_text


# ---- What a material's numbers give reason to say ------------------------------------------------------


def test_a_table_says_where_it_is_continued_and_with_which_index(load):
    narrow = load("[index]\nwavelength_nm = [586, 656]\nn = [1.70, 1.60]")
    assert narrow.continued_nm == ((380.0, 586.0), (656.0, 760.0))
    assert narrow.notes == (
        # 1.70 + 155.2 / 700, 1.70 - 3.3 / 700, 1.60 - 30.7 / 700
        "index table of 586 to 656 nm, continued to 380 and 760 nm as its end rows run: "
        "n is 1.9217 at 430.8, 1.6953 at 589.3, 1.5561 at 686.7 nm",
        "Abbe number 2.86, where transparent solids have 6 to 150",
    )


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (("[400, 500, 700]", "[300, 500, 700]"), "index table of 300 to 700 nm, continued to 760 nm as its"),
        (("[400, 500, 700]", "[400, 500, 800]"), "index table of 400 to 800 nm, continued to 380 nm as its"),
        (("[400, 500, 700]", "[380, 500, 760]"), None),
    ],
)
def test_a_table_says_which_end_is_continued(edit, told, load):
    notes = load(edited(*edit, BY_TABLE)).notes
    assert notes == () if told is None else notes[0].startswith(told)


def test_a_formula_says_where_it_is_continued(load):
    assert load(edited(RANGE, "[400, 700]")).notes == (
        "made up",
        "formula of 400 nm and above, continued to 380 nm",
        "formula of 700 nm and below, continued to 760 nm",
    )


def test_absorption_says_where_its_ends_hold(load):
    assert load(edited(ABSORBED, "[380, 500, 700]")).cautions == (
        "absorption of 380 to 700 nm, beyond which its end values hold",
    )


def test_a_file_is_warned_of_when_it_is_loaded_and_once(tmp_path):
    path = tmp_path / "narrow.toml"
    path.write_text("[index]\nwavelength_nm = [586, 656]\nn = [1.70, 1.60]")
    with pytest.warns(GemrenderWarning) as caught:
        material = load_material(path)
    assert [str(warning.message) for warning in caught] == [f"{path}: {line}" for line in material.cautions]
    assert len(material.cautions) == 2
    load_material(path)  # another warning would be an error


@pytest.mark.parametrize("name", material_names())
def test_what_comes_with_gemrender_has_a_usual_dispersion(name):
    assert not any("Abbe" in note for note in load_material(name).notes)


#: The glass N-BK7 as SCHOTT's catalogue has it, C in um^2; by its data sheet V_d is 64.17.
BK7 = "[[1.03961212, 0.00600069867], [0.231792344, 0.0200179144], [1.01046945, 103.560653]]"


def glass(formula, coefficients):
    return f'[index]\nformula = "{formula}"\ncoefficients = {coefficients}\nrange_nm = [380, 760]\n'


def test_a_catalogues_glass_has_its_abbe_number(load):
    made = load(glass("sellmeier-2", BK7))
    assert made.abbe_number == pytest.approx(64.17, abs=0.1)  # V_D, by another line of the yellow
    assert made.notes == ()


def test_a_catalogues_glass_in_the_wrong_form_is_refused_with_the_right_one(load):
    with pytest.raises(
        InputError, match=r'index\.coefficients: Abbe number 57.*"sellmeier-2" \(Abbe number 64\.1'
    ):
        load(glass("sellmeier", BK7))


@pytest.mark.parametrize("name", ["diamond", "cubic zirconia", "strontium titanate"])
def test_a_pole_in_visible_light_names_the_other_form(name, load):
    pairs = [list(pair) for pair in load_material(name).dispersion.coefficients]
    with pytest.raises(InputError, match=r'nm; with C in um it is formula = "sellmeier"$'):
        load(glass("sellmeier-2", pairs))


@pytest.mark.parametrize("name", ["sapphire", "spinel"])
def test_poles_near_visible_light_are_told_with_the_other_form(name, load):
    pairs = [list(pair) for pair in load_material(name).dispersion.coefficients]
    (note,) = load(glass("sellmeier-2", pairs)).notes
    assert note.startswith("Abbe number 4.")
    assert note.endswith('; with C in um it is formula = "sellmeier"')


def test_no_dispersion_is_no_reason_to_refuse(load):
    made = load(glass("sellmeier", "[[1.25, 0.0]]"))
    assert (made.abbe_number, made.notes) == (None, ())


# ---- Sheets and templates ------------------------------------------------------------------------------


def test_the_sheet_of_diamond():
    sheet = material_sheet("diamond")
    peter = [published("diamond").get_refractive_index(w) for w in (430.8, 486.1, 589.3, 656.3, 686.7)]
    n_g, n_f, n_d, n_c, n_b = peter
    assert [sheet.n_g, sheet.n_f, sheet.n_d, sheet.n_c, sheet.n_b] == pytest.approx(peter, rel=10 * ROUNDING)
    assert sheet.abbe_number == pytest.approx((n_d - 1) / (n_f - n_c), rel=DIFFERENCE)
    assert sheet.dispersion_b_g == pytest.approx(n_g - n_b, rel=DIFFERENCE)
    assert (sheet.density, sheet.index_from, sheet.range_nm) == (3.52, "sellmeier", (226.0, 760.0))
    assert (sheet.absorbs, sheet.notes) == (False, ())


def test_a_sheet_is_a_line_of_json(load):
    made = material_sheet(load(edited(ABSORBED, "[380, 500, 700]"))).to_dict()
    assert list(made) == [
        "name", "n_G", "n_F", "n_D", "n_C", "n_B", "abbe_number", "dispersion_b_g", "density", "index_from",
        "range_nm", "continued_nm", "absorbs", "source", "notes", "optic_class", "n_o", "n_e", "n_alpha",
        "n_beta", "n_gamma", "birefringence", "optic_sign", "two_v_deg", "pleochroic",
    ]  # fmt: skip
    assert json.loads(json.dumps(made)) == made
    assert made["notes"] == ["made up", "absorption of 380 to 700 nm, beyond which its end values hold"]
    assert (made["name"], made["range_nm"], made["absorbs"]) == ("My glass", [360.0, 1000.0], True)


def test_the_sheet_of_a_file(tmp_path):
    path = tmp_path / "glass.toml"
    path.write_text(edited(ABSORBED, "[380, 500, 700]"))
    sheet = material_sheet(path)  # a warning would be an error: the notes have it
    assert sheet == material_sheet(load_material(path, warn=False))
    assert len(sheet.notes) == 2


def test_the_sheet_of_an_index():
    sheet = material_sheet(1.7)
    assert (sheet.n_g, sheet.n_b, sheet.abbe_number, sheet.dispersion_b_g, sheet.density) == (
        1.7,
        1.7,
        None,
        0,
        None,
    )


@pytest.mark.parametrize(
    "name", [*sorted(PAGES), "ruby", "blue sapphire", "fancy yellow diamond", "diamond m"]
)
def test_a_template_loads_to_the_same_material(name, load):
    known, made = load_material(name), load(material_template(name))
    assert made == known
    tried = np.linspace(*known.wavelengths_nm, 50)
    np.testing.assert_array_equal(made.index(tried), known.index(tried))
    np.testing.assert_array_equal(made.absorption_per_mm(ABSORBED_NM), known.absorption_per_mm(ABSORBED_NM))
    assert made.notes == known.notes


@pytest.mark.parametrize("text", [BY_FORMULA, BY_TABLE])
def test_a_template_of_a_users_material_loads_to_it(text, load):
    known = load(text)
    assert load(material_template(known)) == known


def test_the_commented_part_of_a_template_is_a_material_too(load):
    text = material_template("diamond")
    uncommented = re.sub(r"^# (?=\[absorption|wavelength_nm|per_mm)", "", text, flags=re.MULTILINE)
    assert load(uncommented).absorption_per_mm([380, 760]).tolist() == [0.3, 0.0]


def test_templates_of_stones_and_set_ups_load(tmp_path):
    for name, template, load_file, load_name in (
        ("inoue-3", stone_template, load_stone, load_stone),
        ("studio", setup_template, load_setup, load_setup),
    ):
        path = tmp_path / f"{name}.toml"
        path.write_text(template(name), encoding="utf-8")
        assert load_file(path).name == load_name(name).name


@pytest.mark.parametrize("template", [stone_template, setup_template])
@pytest.mark.parametrize("name", ["", "../inoue-3", "inoue-33"])
def test_a_template_of_nothing_is_refused(template, name):
    with pytest.raises(InputError, match=r"^name = '.*': must be (one of [a-z]+|a bundled stone \(see: )"):
        template(name)
