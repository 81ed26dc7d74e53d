"""Pleochroism: absorption of light whose field is along each principal direction of a crystal.

Uniaxial crystals: of the ordinary ray, then of the extraordinary one. Biaxial: along the axes alpha, beta and
gamma. As in `absorption`: where bands are and which ray has them is literature, how wide they are is near
it, and how strong they are is chosen.
"""

from __future__ import annotations

import numpy as np

from gemrender.optics import absorption
from gemrender.optics.bands import absorption_table, band, line, rise
from gemrender.optics.tabulated import Table

__all__ = [
    "alexandrite",
    "amethyst",
    "aquamarine",
    "blue_sapphire",
    "blue_topaz",
    "blue_zircon",
    "citrine",
    "emerald",
    "green_tourmaline",
    "peridot",
    "ruby",
    "tanzanite",
    "unheated_tanzanite",
]

# ---- Uniaxial: ordinary, extraordinary -----------------------------------------------------------------


def ruby() -> tuple[Table, ...]:
    """Return the absorption of a ruby: purplish red, and orange-red in the extraordinary ray [1/mm].

    There the Y band is at 542 nm and half as strong, the U band at 397 nm. McClure, J. Chem. Phys. 36, 2757
    (1962); Cronemeyer, J. Opt. Soc. Am. 56, 1703 (1966).
    """
    extraordinary = 0.9 * (
        band(18450, 0.45, below=2000, above=3600)
        + band(25200, 1.0, below=4200, above=3600)
        + rise(300, 0.3, 2500)
    )
    return absorption.ruby(), absorption_table(extraordinary)


def blue_sapphire() -> tuple[Table, ...]:
    """Return the absorption of a blue sapphire: blue, and greenish blue in the extraordinary ray [1/mm].

    There the charge transfer of Fe2+ and Ti4+ is at 700 nm, and little of it at 580 nm. Ferguson & Fielding,
    Chem. Phys. Lett. 10, 262 (1971).
    """
    extraordinary = 0.25 * (
        band(17250, 0.4, below=3900, above=4600)
        + band(14300, 0.75, below=3000, above=3000)
        + line(450, 0.12, 14)
        + line(388, 0.3, 8)
        + line(377, 0.35, 8)
        + rise(330, 0.6, 1500)
    )
    return absorption.blue_sapphire(), absorption_table(extraordinary)


def amethyst() -> tuple[Table, ...]:
    """Return the absorption of an amethyst: bluish violet, and reddish violet, weakly [1/mm].

    The bands are those of the ordinary ray (`absorption.amethyst`). That the two rays differ, and in which
    sense, is GIA, Gem Reference Guide (1988); by how much is chosen.
    """
    extraordinary = 0.2 * (
        band(18900, 0.95, below=3600, above=4600) + band(28000, 0.9, below=5200, above=5200)
    )
    return absorption.amethyst(), absorption_table(extraordinary)


def citrine() -> tuple[Table, ...]:
    """Return the absorption of a citrine: yellow, the extraordinary ray a little weaker [1/mm].

    Fe3+ in quartz, a rise to the ultraviolet: Lehmann & Bambauer, Angew. Chem. Int. Ed. 12, 283 (1973). By
    how much the rays differ is chosen.
    """
    ordinary = rise(430, 0.2, 3300)
    return absorption_table(ordinary), absorption_table(0.8 * ordinary)


def green_tourmaline() -> tuple[Table, ...]:
    """Return the absorption of a green elbaite: its ordinary ray is nearly dark [1/mm].

    Fe2+ at 720 and 1100 nm, ten times as strong in the ordinary ray where Fe3+ is beside it: Mattson &
    Rossman, Phys. Chem. Miner. 14, 163 (1987); the charge transfer from Fe2+ to Ti4+ at 415 nm:
    Mattson & Rossman, Phys. Chem. Miner. 16, 78 (1988), of other minerals.
    """
    iron = band(13900, 1.0, below=4600, above=4200) + band(9100, 0.8, below=3000, above=3000)
    transfer = band(24100, 0.8, below=5600, above=5600) + rise(330, 0.4, 3000)
    return absorption_table(1.5 * iron + 1.4 * transfer), absorption_table(0.15 * iron + 0.1 * transfer)


def blue_zircon() -> tuple[Table, ...]:
    """Return the absorption of a heated blue zircon: blue, and nearly colourless in the other ray [1/mm].

    A band from 550 to 770 nm in the ordinary ray: Renfro, Gems Gemol. 52, 242 (2016); Zeug et al., J. Gemmol.
    36, 112 (2018), without its cause; and the narrow line of U4+ at 653.5 nm that GIA's guide prints.
    """
    uranium = line(653.5, 0.02, 3)
    ordinary = band(15400, 0.13, below=2600, above=4600) + uranium
    return absorption_table(ordinary + rise(380, 0.01, 2500)), absorption_table(0.05 * ordinary + uranium)


def emerald() -> tuple[Table, ...]:
    """Return the absorption of an emerald: green, and bluish green in the other ray [1/mm].

    Cr3+ in beryl, ordinary ray at 430 and 600 nm, extraordinary ray at 420 and 630 nm: Wood & Nassau, Am.
    Mineral. 53, 777 (1968); Burns, Mineralogical Applications of Crystal Field Theory, 2nd ed. (1993).
    """
    ordinary = (
        band(23250, 1.0, below=3200, above=3400)
        + band(16650, 0.85, below=2300, above=2700)
        + line(683, 0.25, 3)
        + rise(330, 0.4, 2500)
    )
    extraordinary = (
        band(23900, 0.75, below=3200, above=3400)
        + band(15870, 0.7, below=2100, above=2900)
        + line(683, 0.15, 3)
        + rise(330, 0.4, 2500)
    )
    return absorption_table(0.2 * ordinary), absorption_table(0.2 * extraordinary)


def aquamarine() -> tuple[Table, ...]:
    """Return the absorption of an aquamarine: nearly colourless, and blue in the extraordinary ray [1/mm].

    Fe2+ in beryl, 620 nm in the extraordinary ray, 820 nm in both; Fe3+ at 370 and 427 nm. Wood & Nassau,
    Am. Mineral. 53, 777 (1968); Goldman, Rossman & Parkin, Phys. Chem. Miner. 3, 225 (1978).
    """
    both = line(427, 0.006, 9) + band(12200, 0.06, below=2300, above=2300)
    ordinary = both + line(370, 0.02, 14) + rise(360, 0.03, 2200)
    extraordinary = both + band(16100, 0.06, below=3400, above=4200) + rise(360, 0.01, 2200)
    return absorption_table(ordinary), absorption_table(extraordinary)


# ---- Biaxial: alpha, beta, gamma -----------------------------------------------------------------------


def blue_topaz() -> tuple[Table, ...]:
    """Return the absorption of an irradiated blue topaz, the same blue in two depths [1/mm].

    The colour centre at 620 nm: Nassau, Gems Gemol. 21, 26 (1985). Which direction has how much of it is
    chosen.
    """
    centre = band(16100, 0.06, below=3600, above=4200)
    return tuple(absorption_table(share * centre) for share in (0.75, 1.0, 0.85))


def peridot() -> tuple[Table, ...]:
    """Return the absorption of a peridot: yellowish green, weakly pleochroic [1/mm].

    Fe2+ in olivine: the flank of the bands about 1050 nm, strongest along gamma; the lines at 453, 473 and
    493 nm; and the rise to the ultraviolet. Burns, Mineralogical Applications of Crystal Field Theory, 2nd
    ed. (1993); Farrell & Newnham, Am. Mineral. 50, 1972 (1965).
    """
    lines = line(453, 0.02, 14) + line(473, 0.015, 14) + line(493, 0.025, 10)
    ultraviolet = rise(400, 0.16, 3000)
    infrared = band(9500, 1.0, below=3000, above=4800)
    return tuple(
        absorption_table(a * infrared + b * (lines + ultraviolet))
        for a, b in ((1.8, 0.9), (1.6, 1.1), (3.0, 1.0))
    )


def tanzanite() -> tuple[Table, ...]:
    """Return the absorption of a heated tanzanite: red-violet, blue, and blue [1/mm].

    V3+ in zoisite, at 528, 595 and 750 nm; heating takes away the band at 455 nm. Faye & Nickel, Can.
    Mineral. 10, 812 (1971), of the colours along the directions and what heating does. How much of each band
    a direction has is chosen.
    """
    return tuple(absorption_table(table) for table in _vanadium())


def unheated_tanzanite() -> tuple[Table, ...]:
    """Return the absorption of a tanzanite before heating: red-violet, blue, yellow-green [1/mm].

    As `tanzanite`, with the band at 455 nm along gamma. Faye & Nickel, Can. Mineral. 10, 812 (1971).
    """
    alpha, beta, gamma = _vanadium()
    added = band(22000, 0.22, below=3400, above=5200) + rise(380, 0.1, 3000)
    gamma = 0.4 * gamma + band(13400, 0.15, below=2200, above=2600) + added
    return tuple(absorption_table(table) for table in (alpha + 0.1 * added, beta, gamma))


def _vanadium() -> tuple[np.ndarray, ...]:
    v528, v595, v750 = (
        band(18950, 1.0, below=2100, above=2600),
        band(16800, 1.0, below=2200, above=2600),
        band(13400, 1.0, below=2200, above=2200),
    )
    ultraviolet = band(26800, 0.05, below=3200, above=3200)
    return (
        0.13 * v528 + 0.02 * v595 + ultraviolet,
        0.05 * v528 + 0.2 * v595 + 0.12 * v750 + ultraviolet,
        0.03 * v528 + 0.16 * v595 + 0.05 * v750 + ultraviolet,
    )


def alexandrite() -> tuple[Table, ...]:
    """Return the absorption of an alexandrite: purplish red, orange-yellow, green by daylight [1/mm].

    Cr3+ in chrysoberyl: two bands, near 420 and near 580 nm, and the R lines at 680 nm. Farrell & Newnham,
    Am. Mineral. 50, 1972 (1965). Where they are and how strong along each direction is chosen, so that the
    colours are those that O'Donoghue, Gems, 6th ed. (2006) names.
    """
    red_line = line(680, 0.04, 2) + rise(330, 0.1, 2500)
    alpha = band(17900, 0.2, below=2400, above=3200) + band(24000, 0.18, below=3600, above=3600)
    beta = band(17500, 0.11, below=2200, above=3400) + band(22700, 0.3, below=3600, above=4600)
    gamma = band(16500, 0.26, below=2100, above=2800) + band(23500, 0.26, below=3200, above=3600)
    return tuple(absorption_table(bands + red_line) for bands in (alpha, beta, gamma))
