"""Body colours: absorption coefficients modelled from published band positions and widths.

Their shapes are those of `bands`. Where bands are is literature; how wide they are is near it, rounded; how
strong they are is chosen, so that a brilliant of about one carat, in which light goes some 10 mm, has the
colour that its name promises. Of birefringent crystals this is the ordinary ray; `pleochroism` has all
directions. No fluorescence.
"""

from __future__ import annotations

import string

from gemrender.optics.bands import absorption_table, band, line, rise
from gemrender.optics.tabulated import Table

__all__ = [
    "DIAMOND_GRADES",
    "amethyst",
    "blue_sapphire",
    "cape_diamond",
    "fancy_yellow",
    "rhodolite",
    "ruby",
]

#: Colour grades of the GIA's scale from D, colourless, to Z, light yellow.
DIAMOND_GRADES = string.ascii_lowercase[3:]
#: Absorption coefficient of a Z diamond at N3's line [1/mm], without the continuum below it.
_Z_PER_MM = 0.25


def ruby() -> Table:
    """Return the absorption of a ruby [1/mm].

    Cr3+ in corundum, ordinary ray: the U band at 405 nm (4A2 to 4T1) and the Y band at 555 nm (4A2 to 4T2),
    with the window between them that makes a ruby purplish; and the charge transfer in the ultraviolet.
    McClure, J. Chem. Phys. 36, 2757 (1962); Cronemeyer, J. Opt. Soc. Am. 56, 1703 (1966).
    """
    return absorption_table(
        0.9
        * (
            band(18000, 0.9, below=2000, above=3600)
            + band(24700, 1.0, below=4200, above=3600)
            + rise(300, 0.3, 2500)
        )
    )


def blue_sapphire() -> Table:
    """Return the absorption of a blue sapphire [1/mm].

    Charge transfer from Fe2+ to Ti4+ at 580 nm (ordinary ray) and 700 nm (extraordinary ray), Fe3+ at 377,
    388 and 450 nm, and the charge transfer from oxygen in the ultraviolet. Ferguson & Fielding, Chem. Phys.
    Lett. 10, 262 (1971); Nassau, The Physics and Chemistry of Color (Wiley, 1983).
    """
    return absorption_table(
        0.25
        * (
            band(17250, 1.0, below=3900, above=4600)
            + band(14300, 0.4, below=3000, above=3000)
            + line(450, 0.06, 14)
            + line(388, 0.3, 8)
            + line(377, 0.35, 8)
            + rise(330, 0.4, 1500)
        )
    )


def amethyst() -> Table:
    """Return the absorption of an amethyst [1/mm].

    Fe4+ in quartz, ordinary ray: the band at 545 nm (Lehmann & Moore, Science 152, 1061 (1966)) and that at
    357 nm (Hassan & Cohen, Am. Mineral. 59, 709 (1974)). Its strength is for a stone of some 10 mm.
    """
    return absorption_table(
        0.2 * (band(18350, 1.0, below=3600, above=4600) + band(28000, 0.9, below=5200, above=5200))
    )


def rhodolite() -> Table:
    """Return the absorption of a rhodolite, a pyrope-almandine garnet [1/mm].

    Fe2+ in garnet: bands at 504, 520 to 527 and 573 nm, and weak ones at 423, 460, 610 and 685 nm (GIA, Gem
    Reference Guide (1988)), which overlap, and the rise to the ultraviolet. Manning, Can. Mineral. 9, 237
    (1967), told them apart in almandine and pyrope.
    """
    return absorption_table(
        0.3
        * (
            line(504, 0.8, 20)
            + line(526, 0.55, 24)
            + line(573, 0.7, 36)
            + line(423, 0.15, 14)
            + line(460, 0.28, 24)
            + line(610, 0.1, 28)
            + line(685, 0.05, 36)
            + band(19600, 0.3, below=2800, above=5200)
            + rise(400, 0.7, 3600)
        )
    )


def fancy_yellow() -> Table:
    """Return the absorption of a fancy yellow diamond, type Ib [1/mm].

    Isolated nitrogen (C centres): a continuum that rises from 560 nm to the ultraviolet, without a peak in
    the visible. Dyer, Raal, du Preez & Loubser, Phil. Mag. 11, 763 (1965); Collins, J. Gemmol. 18, 37 (1982).
    """
    return absorption_table(rise(450, 0.3, 1500))


def cape_diamond(grade: str) -> Table | None:
    """Return the absorption of a diamond of a colour grade [1/mm]; None for D.

    The cape series of type Ia: N3 at 415.2 nm with its sidebands at 403 and 394 nm and more beyond, N2 at
    478 nm with its companions at 423, 435, 452 and 465 nm, and the continuum that rises to the ultraviolet.
    Collins, J. Gemmol. 18, 37 (1982); Walker, Rep. Prog. Phys. 42, 1605 (1979). All grades have one shape.

    Parameters
    ----------
    grade : str
        One of `DIAMOND_GRADES`. The strength goes as the power 1.5 of the steps from D: so the first grades
        are next to colourless, K is faint and Z light yellow.
    """
    steps = DIAMOND_GRADES.index(grade)
    if not steps:
        return None
    n3 = (
        line(415.2, 1.0, 3)
        + line(403, 0.75, 9)
        + line(394, 0.75, 10)
        + line(384, 0.7, 12)
        + line(375, 0.5, 14)
    )
    n2 = (
        line(478, 0.12, 8)
        + line(465, 0.05, 8)
        + line(452, 0.08, 12)
        + line(435, 0.05, 10)
        + line(423, 0.1, 9)
    )
    strength = _Z_PER_MM * (steps / (len(DIAMOND_GRADES) - 1)) ** 1.5
    return absorption_table(strength * (n3 + n2 + rise(415.2, 0.35, 2300)))
