"""Materials: index by wavelength against the published database, body colours, files and their refusals."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from glasses import (
    ABSORBED,
    BY_FORMULA,
    BY_TABLE,
    COEFFICIENTS,
    DIRECTIONS,
    PAGES,
    PER_MM,
    RANGE,
    edited,
    published,
)
from physics_tolerances import FOUR_DECIMALS, ROUNDING

from gemrender import InputError, load_stone
from gemrender.cli.program import run
from gemrender.colorimetry import colour_science
from gemrender.optics import Material, carat_to_girdle_diameter_mm, load_material, material_names
from gemrender.optics.absorption import DIAMOND_GRADES
from gemrender.optics.dispersion import FORMULAE, Formula
from gemrender.optics.material import INDEX_RANGE, VISIBLE_NM
from gemrender.optics.tabulated import Table

colour = colour_science()
GRADES = [f"diamond {grade}" for grade in DIAMOND_GRADES]
CRYSTAL_OF = {
    **{name: name for name in PAGES},
    "garnet": "garnet",
    **{name: name for name in ("beryl", "topaz", "tourmaline", "zircon")},
    **dict.fromkeys(("aquamarine", "emerald"), "beryl"),
    **{f"blue {name}": name for name in ("topaz", "zircon")},
    "alexandrite": "chrysoberyl",
    "citrine": "quartz",
    "green tourmaline": "tourmaline",
    "peridot": "peridot",
    **dict.fromkeys(("tanzanite", "unheated tanzanite"), "tanzanite"),
    "rhodolite": "garnet",
    "amethyst": "quartz",
    "ruby": "sapphire",
    "blue sapphire": "sapphire",
    "fancy yellow diamond": "diamond",
    **dict.fromkeys(GRADES, "diamond"),
}
ABSORBED_NM = np.arange(340.0, 861.0, 0.5)


# ---- Index by wavelength -------------------------------------------------------------------------------


def test_every_material_has_its_crystal():
    assert material_names() == sorted(CRYSTAL_OF)


@pytest.mark.parametrize("name", sorted(PAGES))
def test_index_is_that_of_the_database(name):
    low, high = load_material(name).range_nm
    wavelengths = np.concatenate(
        [np.linspace(low, high, 41), np.linspace(max(low, VISIBLE_NM[0]), VISIBLE_NM[1], 41)]
    )
    wavelengths = np.clip(wavelengths, low * (1 + ROUNDING), high * (1 - ROUNDING))  # its ends in micrometres
    expected = [published(name).get_refractive_index(float(w)) for w in wavelengths]
    np.testing.assert_allclose(load_material(name).index(wavelengths), expected, rtol=10 * ROUNDING)


@pytest.mark.parametrize("name", sorted(PAGES))
def test_range_is_that_of_the_database(name):
    assert load_material(name).range_nm == pytest.approx(
        published(name).get_wl_range(unit="nm", quantity="n"), rel=ROUNDING
    )


def test_a_garnet_has_the_printed_index_and_dispersion():
    garnet = load_material("garnet")
    assert float(garnet.index(589.3)) == pytest.approx(1.760, abs=FOUR_DECIMALS)
    assert garnet.dispersion_b_g == pytest.approx(0.026, abs=FOUR_DECIMALS)


@pytest.mark.parametrize("name", sorted(set(CRYSTAL_OF) - set(PAGES)))
def test_body_colour_has_the_crystals_index(name):
    assert load_material(name).dispersion == load_material(CRYSTAL_OF[name]).dispersion


@pytest.mark.parametrize("name", sorted(PAGES))
def test_dispersion_is_normal_in_visible_light(name):
    assert (np.diff(load_material(name).index(np.arange(380, 761))) < 0).all()


@pytest.mark.parametrize(("name", "printed"), [("diamond", 0.0444), ("cubic zirconia", 0.0604)])
def test_dispersion_that_gemmologists_print(name, printed):
    assert load_material(name).dispersion_b_g == pytest.approx(printed, abs=FOUR_DECIMALS)


@pytest.mark.parametrize("name", sorted(PAGES))
def test_continued_formula_is_noted(name):
    low, high = published(name).get_wl_range(unit="nm", quantity="n")
    continued = low > VISIBLE_NM[0] or high * (1 + ROUNDING) < VISIBLE_NM[1]
    assert any("continued" in note for note in load_material(name).notes) == continued


@pytest.mark.parametrize("name", ["moissanite", "quartz", "ruby", "rutile", "sapphire", "zircon"])
def test_birefringence_is_noted(name):
    assert "scores take the ordinary index" in load_material(name).note


@pytest.mark.parametrize("name", ["alexandrite", "peridot", "tanzanite", "topaz"])
def test_two_optic_axes_are_noted(name):
    assert "scores take the middle index" in load_material(name).note


@pytest.mark.parametrize(
    ("formula", "coefficients", "at_500_nm"),
    [
        ("sellmeier", [[3.0, 0.25]], np.sqrt(1 + 3.0 / (1 - 0.25))),
        ("sellmeier-2", [[3.0, 0.0625], [0.5, 0.0]], np.sqrt(1.5 + 3.0 / (1 - 0.25))),
        ("pole", [3.0, 0.1, 0.05, -0.4], np.sqrt(3.0 + 0.1 / 0.2 - 0.1)),
        ("cauchy", [1.5, 0.01, 0.001], 1.5 + 0.04 + 0.016),
    ],
)
def test_formula_by_hand(formula, coefficients, at_500_nm):
    made = Formula(formula=formula, coefficients=coefficients)
    assert made.index(500.0) == pytest.approx(at_500_nm, rel=ROUNDING)


def test_number_makes_a_material_without_dispersion():
    for material in (Material.constant(1.7), load_material(1.7)):
        assert (material.index(np.linspace(300, 1000, 8)) == 1.7).all()
        assert (material.absorption_per_mm(ABSORBED_NM) == 0).all()


@pytest.mark.parametrize("index", [1.0, 4.01, float("nan"), True])
def test_impossible_number_is_refused(index):
    with pytest.raises(InputError, match=r"index = .*: must be a number from 1\.05 to 4$"):
        load_material(index)


@pytest.mark.parametrize("wavelength_nm", [225.9, 760.1, float("nan")])
def test_wavelength_outside_is_refused(wavelength_nm):
    with pytest.raises(InputError, match="must be from 226 to 760 nm for diamond") as refused:
        load_material("diamond").index([500.0, wavelength_nm])
    assert refused.value.key == "wavelength_nm"


def test_visible_light_is_always_inside():
    for name in material_names():
        low, high = INDEX_RANGE
        index = load_material(name).index(VISIBLE_NM)
        assert ((low <= index) & (index <= high)).all()


# ---- Body colours --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", material_names())
def test_nothing_shines(name):
    assert (load_material(name).absorption_per_mm(ABSORBED_NM) >= 0).all()


@pytest.mark.parametrize("name", [*PAGES, "diamond d", "beryl", "topaz", "tourmaline", "zircon"])
def test_colourless_materials_absorb_nothing(name):
    assert (load_material(name).absorption_per_mm(ABSORBED_NM) == 0).all()


def test_each_grade_absorbs_more_than_the_one_before():
    for better, worse in itertools.pairwise(GRADES):
        more = load_material(worse).absorption_per_mm(ABSORBED_NM) - load_material(better).absorption_per_mm(
            ABSORBED_NM
        )
        assert (more > 0).all()


@pytest.mark.parametrize(
    ("name", "bands_nm", "moved_nm"),  # by the slope of what lies beside them
    [
        ("ruby", [405, 555], 1),
        ("blue sapphire", [377, 388, 450], 2),
        ("blue sapphire", [580], 10),
        ("amethyst", [545], 3),
        ("rhodolite", [423, 460, 573], 3),
        ("rhodolite", [504], 6),
        ("diamond z", [394, 403, 415.2, 423, 452, 465, 478], 2),
    ],
)
def test_bands_are_where_the_literature_has_them(name, bands_nm, moved_nm):
    a = load_material(name).absorption_per_mm(np.arange(360, 831))
    peaks = 361 + np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] > a[2:]))
    for band in bands_nm:
        assert np.abs(peaks - band).min() <= moved_nm


def through(name, path_mm):
    """Lightness, chroma and hue [deg] (CIELAB) of D65 through a path."""
    nm = np.arange(360.0, 831.0)
    shape = colour.SpectralShape(360, 830, 1)
    light = colour.SDS_ILLUMINANTS["D65"].copy().align(shape).values
    eye = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape).values
    white = light @ eye
    left = (light * np.exp(-path_mm * load_material(name).absorption_per_mm(nm))) @ eye
    lab = colour.XYZ_to_Lab(left / white[1], colour.XYZ_to_xy(white))
    return colour.models.Lab_to_LCHab(lab)


@pytest.mark.parametrize(
    ("name", "lightness", "chroma", "hue_deg"),  # lowest and highest
    [
        ("ruby", (30, 50), (60, 90), (0, 30)),  # red, a little purplish
        ("blue sapphire", (35, 60), (60, 100), (280, 305)),  # blue of sRGB: 306
        ("amethyst", (35, 60), (35, 75), (305, 335)),
        ("rhodolite", (25, 55), (45, 95), (0, 30)),  # red, a little purplish
        ("fancy yellow diamond", (80, 95), (60, 100), (85, 105)),  # yellow of sRGB: 103
        ("diamond z", (95, 99), (20, 35), (95, 115)),
        ("diamond k", (99, 100), (3, 8), (95, 115)),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_colour_of_daylight_through_ten_millimetres(name, lightness, chroma, hue_deg):
    for value, (low, high) in zip(through(name, 10.0), (lightness, chroma, hue_deg), strict=True):
        assert low <= value <= high


# ---- Names ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["Blue-Sapphire", "blue_sapphire", " BLUE  sapphire"])
def test_case_hyphens_and_underscores_do_not_count(name):
    assert load_material(name) is load_material("blue sapphire")


def test_none_is_diamond():
    assert load_material(None) is load_material("diamond")


@pytest.mark.parametrize(
    ("name", "guess"), [("saphire", "sapphire"), ("diamont", "diamond"), ("2.4", None), ("", None)]
)
def test_unknown_name_is_refused_with_the_known_ones(name, guess):
    with pytest.raises(InputError) as refused:
        load_material(name)
    told = str(refused.value)
    assert all(known in told for known in PAGES)
    assert "diamond d to diamond z" in told
    assert "TOML file" in told
    assert told.endswith(f"did you mean {guess}?") == (guess is not None)


def test_a_name_wins_over_a_file_called_like_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ruby").write_text("no material")
    assert load_material("ruby").name == "ruby"


def test_materials_are_listed(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")  # no name is broken in two
    assert run(["materials"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in set(CRYSTAL_OF) - set(GRADES))
    assert "diamond e to diamond z" in told
    assert f"{load_material('diamond').dispersion_b_g:.4f}" in told


# ---- Files ---------------------------------------------------------------------------------------------


@pytest.fixture
def load(tmp_path):
    """Load a material from the text of a file, whatever there is to warn of."""

    def load_text(text, name="glass.toml"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_material(path, warn=False)

    return load_text


def test_file_with_a_formula(load):
    assert load(BY_FORMULA) == Material(
        name="My glass",
        density=3.2,
        source="catalogue",
        note="made up",
        dispersion=Formula(formula="sellmeier", coefficients=((1.0, 0.1), (0.2, 0.2))),
        range_nm=(360.0, 1000.0),
        absorption=Table(wavelength_nm=(380, 500, 760), values=(0.3, 0.1, 0.0), key="per_mm"),
    )


@pytest.mark.parametrize("name", sorted(set(PAGES) - set(DIRECTIONS)))
def test_built_in_material_as_a_file(name, load):
    known = load_material(name)
    coefficients = [list(c) if isinstance(c, tuple) else c for c in known.dispersion.coefficients]
    made = load(
        f'name = "{name}"\ndensity = {known.density}\nsource = "{known.source}"\nnote = "{known.note}"\n'
        f'[index]\nformula = "{known.dispersion.formula}"\ncoefficients = {coefficients}\n'
        f"range_nm = {list(known.range_nm)}\n"
    )
    assert made == known


@pytest.mark.parametrize(
    ("wavelength_nm", "index"),
    [(400, 1.6), (425, 1.575), (600, 1.49), (380, 1.62), (760, 1.474)],  # beyond its ends as the end pieces
)
def test_table_is_linear(wavelength_nm, index, load):
    assert load(BY_TABLE).index(wavelength_nm) == pytest.approx(index, rel=ROUNDING)


@pytest.mark.parametrize(("wavelength_nm", "per_mm"), [(440, 0.2), (630, 0.05), (300, 0.3), (900, 0.0)])
def test_absorption_is_linear_and_keeps_its_ends(wavelength_nm, per_mm, load):
    assert load(BY_FORMULA).absorption_per_mm(wavelength_nm) == pytest.approx(per_mm, abs=ROUNDING)


def test_file_without_a_name_is_called_like_the_file(load):
    assert load(BY_TABLE, "crown glass.toml").name == "crown glass"


def test_file_may_start_with_a_byte_order_mark(load):
    assert load(b"\xef\xbb\xbf" + BY_TABLE.encode()).density is None


#: What is wrong, the file, and what is told of it after the file's name.
WRONG = [
    ("empty", "  \n", "is empty"),
    ("not TOML", "[index", "is not TOML: "),
    ("not UTF-8", b"name = '\xff'", "must be text in UTF-8; byte 9 is not"),
    ("too big", "#" * 99 + "\n" + ("#" * 99 + "\n") * 10_000, "is no material file: larger than 1000000"),
    ("nested", "a = " + "[" * 3000 + "]" * 3000, "line 1: is 6004 characters long"),
    ("nested keys", f"a{'.a' * 1700} = 1", "a = (dict): unknown key"),
    ("nested sections", f"[index{'.a' * 1500}]\n{'.'.join('b' * 1500)} = 1", "index.a = (dict): unknown key"),
    ("huge number", "density = 0x" + "f" * 3400 + "\n" + BY_TABLE, "density = "),
    ("unknown key", "colour = 'red'\n" + BY_TABLE, "colour = 'red': unknown key; must be one of name, "),
    ("slip", "densty = 3\n" + BY_TABLE, "did you mean density?"),
    ("unknown key of a section", BY_TABLE + "k = 1", "index.k = 1: unknown key; must be one of formula, "),
    ("no index", "name = 'x'", "[index]: missing; needs formula, coefficients, range_nm; or wavelength_nm "),
    ("index no section", "index = 1.5", "index = 1.5: must be a section: a line [index]"),
    ("neither form", "[index]", "[index]: needs exactly one of: formula, "),
    ("both forms", BY_TABLE + "formula = 'cauchy'", "[index]: needs exactly one of: formula, "),
    ("huge coefficient", edited("[0.2, 0.2]", "[0.2, 1e308]"),
     "index.coefficients[1][1] = 1e+308: must be from -1e+09 to 1e+09"),
    ("huge number in a polynomial",
     edited(f'"sellmeier"\ncoefficients = {COEFFICIENTS}', '"cauchy"\ncoefficients = [1.5, -1e308]'),
     "index.coefficients[1] = -1e+308: must be from -1e+09"),
    ("huge row", edited("1.5,", "1e308,", BY_TABLE), "must be from 1.05 to 4 at every wavelength"),
    ("slip in the formula", edited('"sellmeier"', '"selmeier"'), "did you mean sellmeier?"),
    ("index below 1 where a table is continued", edited("1.48", "1.2", BY_TABLE).replace("700", "600"),
     "nm; the table of 400 to 600 nm is continued there as its end rows run"),
    ("nanometres",
     edited(f'"sellmeier"\ncoefficients = {COEFFICIENTS}', '"cauchy"\ncoefficients = [1.5, 4e3]'),
     "nm; coefficients are for wavelengths in micrometres"),
    ("low index in the infrared", edited(COEFFICIENTS, "[[1.0, 0.1], [0.5, 20]]").replace("1000", "17000"),
     "nm; range_nm may be narrower"),
    ("no range", edited(f"range_nm = {RANGE}", ""), "[index]: missing range_nm; needs formula, "),
    ("no n", edited("n = [1.6, 1.5, 1.48]", "", BY_TABLE), "[index]: missing n; needs wavelength_nm, n"),
    ("name", edited('"My glass"', "3"), "name = 3: must be one line of"),
    ("no name", edited('"My glass"', '" "'), "name = '': must be one line of 1 to 100"),
    ("note", edited('"made up"', '"a\\nb"'), "note = 'a\\nb': must be one line of at most 1000"),
    ("density", edited("3.2", "-3.2"), "density = -3.2: must be a number from 0.5 to 25 g/cm3"),
    ("NaN density", edited("3.2", "nan"), "density = nan: must be"),
    ("formula", edited('"sellmeier"', '"schott"'),
     f"index.formula = 'schott': must be one of {', '.join(FORMULAE)}"),
    ("coefficients", edited(COEFFICIENTS, "1.5"),
     "index.coefficients = 1.5: must be pairs [B, C] of n^2 = 1 + "),
    ("no coefficients", edited(COEFFICIENTS, "[]"), "index.coefficients = []: must be pairs [B, C]"),
    ("no pairs", edited(COEFFICIENTS, "[1.0, 0.1]"), "index.coefficients[0] = 1.0: must be pairs [B, C]"),
    ("NaN coefficient", edited("[0.2, 0.2]", "[nan, 0.2]"),
     "index.coefficients[1][0] = nan: must be a finite "),
    ("text as number", edited("[0.2, 0.2]", "['a', 0.2]"),
     "index.coefficients[1][0] = 'a': must be a finite "),
    ("3 of 4 numbers",
     edited(f'"sellmeier"\ncoefficients = {COEFFICIENTS}', '"pole"\ncoefficients = [1, 2, 3]'),
     "index.coefficients = [1.0, 2.0, 3.0]: must be four numbers [A, B, C, D]"),
    ("range of one", edited(RANGE, "[360]"),
     "index.range_nm = [360.0]: must be two wavelengths from 100 to "),
    ("range upside down", edited(RANGE, "[1000, 360]"), "index.range_nm = [1000.0, 360.0]: must be two "),
    ("range in micrometres", edited(RANGE, "[0.36, 1]"), "index.range_nm = [0.36, 1.0]: must be two "),
    ("infrared", edited(RANGE, "[800, 1000]"),
     "index.range_nm = [800.0, 1000.0]: must reach into visible light"),
    ("pole", edited("[0.2, 0.2]", "[0.2, 0.45]"), "index at "),
    ("narrow pole", edited("[0.2, 0.2]", "[1e-9, 0.4501]"), "index at 450.1 nm = "),
    ("low index", edited(COEFFICIENTS, "[[0.1, 0.1]]"),
     "must be from 1.05 to 4 at every wavelength from 360 to "),
    ("high index", edited(COEFFICIENTS, "[[16, 0.1]]"),
     "must be from 1.05 to 4 at every wavelength from 360 to "),
    ("no index at all", edited(COEFFICIENTS, "[[-3, 0.1]]"), "index at 360 nm = nan: must be from 1.05 to 4"),
    ("high row", edited("1.5,", "5,", BY_TABLE),
     "must be from 1.05 to 4 at every wavelength from 380 to 760 nm"),
    ("unsorted rows", edited("[400, 500, 700]", "[400, 700, 500]", BY_TABLE),
     "index.wavelength_nm[2] = 500.0: must be increasing: above 700"),
    ("one row", "[index]\nwavelength_nm = [500]\nn = [1.5]",
     "index.wavelength_nm = [500.0]: must be at least 2"),
    ("rows without n", edited("1.6, 1.5, ", "", BY_TABLE),
     "index.n: must be as many as wavelength_nm: 3, not 1"),
    ("absorption no section", "absorption = 1\n" + BY_TABLE, "absorption = 1: must be a section"),
    ("no per_mm", edited(f"per_mm = {PER_MM}", ""),
     "[absorption]: missing per_mm; needs wavelength_nm, per_mm"),
    ("negative absorption", edited("0.1, 0.0]", "-0.1, 0.0]"),
     "absorption.per_mm[1] = -0.1: must be at least 0"),
    ("huge absorption", edited("0.1, 0.0]", "1e308, 0.0]"),
     "absorption.per_mm[1] = 1e+308: must be at most 1e+06 [1/mm]"),
    ("NaN absorption", edited("0.1, 0.0]", "nan, 0.0]"),
     "absorption.per_mm[1] = nan: must be a finite number"),
    ("unsorted absorption", edited(ABSORBED, "[380, 380, 760]"),
     "absorption.wavelength_nm[1] = 380.0: must be inc"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "told"), [row[1:] for row in WRONG], ids=[row[0] for row in WRONG])
def test_wrong_file_is_refused_in_one_line(text, told, load, tmp_path):
    with pytest.raises(InputError) as refused:
        load(text)
    line = str(refused.value)
    assert line.startswith(f"{tmp_path / 'glass.toml'}: ")
    assert told in line
    assert "\n" not in line


@pytest.mark.parametrize("name", ["none.toml", "a\0b.toml"])
def test_missing_file_is_refused(name):
    with pytest.raises(InputError, match=r"none\.toml: no such file|cannot be read"):
        load_material(name)


#: Values that may be refused in one line; if not, index and absorption are numbers.
HOSTILE = [
    "1e308", "-1e308", "1e155", "1e-308", "5e-324", "-5e-324", "nan", "inf", "-inf", "9" * 400,
    "-" + "9" * 400, "0x" + "f" * 3000, "0", "-0.0", "true", "'x'", "[]", "[[1, 2]]", "{a = 1}", "1979-05-27",
]  # fmt: skip
#: Material files with a number in the place of each {}.
FORMS = {
    "sellmeier": ("coefficients = [[{}, {}], [1.01, {}]]\nrange_nm = [{}, {}]", "1.03 0.077 10.18 360 1000"),
    "sellmeier-2": ("coefficients = [[{}, {}], [1.01, {}]]\nrange_nm = [{}, {}]", "1.03 0.006 99 360 1000"),
    "pole": ("coefficients = [{}, {}, {}, {}]\nrange_nm = [{}, {}]", "3.0 0.01 0.01 -0.01 360 1000"),
    "cauchy": ("coefficients = [{}, {}, {}]\nrange_nm = [{}, {}]", "1.5 0.004 0.0001 360 1000"),
    "": ("wavelength_nm = [{}, {}]\nn = [{}, {}]\n[absorption]\nwavelength_nm = [{}, {}]\nper_mm = [{}, {}]",
         "380 760 1.6 1.5 400 700 0.1 0.2"),
}  # fmt: skip


@pytest.mark.parametrize("formula", FORMS)
def test_no_number_makes_more_than_one_line_of_trouble(formula, load):
    form, numbers = FORMS[formula]
    numbers, accepted = numbers.split(), 0
    kind = f'formula = "{formula}"\n' if formula else ""
    for (i, _), value in itertools.product(enumerate(numbers), HOSTILE):
        text = f"[index]\n{kind}{form.format(*numbers[:i], value, *numbers[i + 1 :])}"
        material, told = None, ""
        try:
            material = load(text)
        except InputError as error:
            told = str(error)
        assert "\n" not in told
        if material is None:
            continue
        accepted += 1
        index = material.index(np.linspace(*material.wavelengths_nm, 50))
        assert ((index >= INDEX_RANGE[0]) & (index <= INDEX_RANGE[1])).all(), text
        assert np.isfinite(material.absorption_per_mm(ABSORBED_NM)).all(), text
    assert accepted > 0  # a coefficient may be 0


# ---- Carats --------------------------------------------------------------------------------------------


def test_a_sphere_of_diamond():
    # 10 mm across: 4/3 pi 5^3 = 523.6 mm^3 of 3.5 mg/mm^3 are 1832.6 mg.
    volume = 4 / 3 * np.pi
    assert carat_to_girdle_diameter_mm(volume * 125 * 3.5 / 200, volume, 3.5) == pytest.approx(10)


def test_a_brilliant_of_one_carat():
    # The trade's brilliant of one carat is 6.5 mm wide.
    volume = load_stone("inoue-3").solid.volume
    assert carat_to_girdle_diameter_mm(1.0, volume, 3.52) == pytest.approx(6.5, abs=0.1)


@pytest.mark.parametrize("key", ["carat", "volume", "density"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_impossible_stone_is_refused(key, value):
    with pytest.raises(InputError, match="must be a finite number above 0") as refused:
        carat_to_girdle_diameter_mm(**{"carat": 1.0, "volume": 2.0, "density": 3.52, key: value})
    assert refused.value.key == key


@pytest.mark.parametrize("carat", [1e9, 1.1e6, 0.9e-5])
def test_weights_that_no_stone_has_are_refused(carat):
    with pytest.raises(InputError, match=r"^carat = .*: must be from 1e-05 to 1e\+06 \[carat\]$"):
        carat_to_girdle_diameter_mm(carat, 2.0, 3.52)
