"""The colourless birefringent crystals that gemrender knows, by their principal indices.

Where a source prints a formula, its coefficients are those, for wavelengths in micrometres; they and the
ranges are those of refractiveindex.info (CC0). Of the other minerals texts print indices at the sodium line,
and one dispersion from B to G, which is taken for all directions. Densities: O'Donoghue, Gems, 6th ed.
(2006), rounded.
"""

from __future__ import annotations

from collections.abc import Iterator

from gemrender.optics.crystals.crystal import Crystal
from gemrender.optics.dispersion import SODIUM_NM, Dispersion, Formula
from gemrender.optics.material import Material

__all__ = ["birefringent_crystals"]

#: What a user should know of them.
_UNIAXIAL = "birefringent: scores take the ordinary index"
_BIAXIAL = "birefringent: scores take the middle index"
_ONE_DISPERSION = "the same dispersion in all directions"
#: Fraunhofer's G and B lines, between which texts print dispersion [um].
_G_UM, _B_UM = 0.4308, 0.6867
#: Range of a dispersion between these lines, rounded [nm].
_B_TO_G_NM = (430.0, 687.0)


def birefringent_crystals() -> Iterator[Material]:
    """Yield the materials, colourless; some are known in colours only."""
    yield _material(
        "calcite", _pair(
            "sellmeier-2",
            ((0.73358749, 0.0), (0.96464345, 1.94325203e-2), (1.82831454, 120.0)),
            ((0.35859695, 0.0), (0.82427830, 1.06689543e-2), (0.14429128, 120.0)),
        ),
        (204, 2172), 2.71, "G. Ghosh, Opt. Commun. 163, 95 (1999)",
    )  # fmt: skip
    yield _material(
        "moissanite", _pair(
            "pole", (6.57232, 0.1401, 0.03178, -0.02153), (6.7452, 0.15352, 0.03597, -0.02249)
        ),
        (435.8, 2325), 3.22, "Wang et al., Laser Photonics Rev. 7, 831 (2013), 6H",
    )  # fmt: skip
    yield _material(
        "quartz", _pair(
            "sellmeier-2",
            ((0.28604141, 0.0), (1.07044083, 1.00585997e-2), (1.10202242, 100.0)),
            ((0.28851804, 0.0), (1.09509924, 1.02101864e-2), (1.15662475, 100.0)),
        ),
        (198, 2053.1), 2.65, "G. Ghosh, Opt. Commun. 163, 95 (1999)",
    )  # fmt: skip
    yield _material(
        "rutile", _pair("pole", (5.913, 0.2441, 0.0803, 0.0), (7.197, 0.3322, 0.0843, 0.0)),
        (430, 1530), 4.26, "J. R. Devore, J. Opt. Soc. Am. 41, 416 (1951)",
        "its own absorption below 430 nm is left out",
    )  # fmt: skip
    yield _material(
        "sapphire", _pair(
            "sellmeier",
            ((1.43134930, 0.0726631), (0.65054713, 0.1193242), (5.3414021, 18.028251)),
            ((1.5039759, 0.0740288), (0.55069141, 0.1216529), (6.5927379, 20.072248)),
        ),
        (200, 5000), 4.00, "Malitson & Dodge, J. Opt. Soc. Am. 62, 1405 (1972); Dodge (1986)",
    )  # fmt: skip
    yield _material(
        "chrysoberyl", tuple(
            _loiko(*four) for four in (  # along the laser crystal's axes c, a and b
                (1.70690, 1.28477, 0.01169, -0.01760),
                (1.78522, 1.21202, 0.01262, -0.01681),
                (1.58829, 1.42711, 0.01113, -0.01696),
            )
        ),
        (250, 2600), 3.73,
        "Walling et al., IEEE J. Quantum Electron. 16, 1302 (1980), by Loiko & Major, Opt. Mater. Express 6, "
        "2177 (2016)",
    )  # fmt: skip
    guide = "GIA, Gem Reference Guide (1988)"
    yield _printed("beryl", (1.583, 1.577), 0.014, 2.72, f"{guide}: indices and dispersion of emerald")
    yield _printed("tourmaline", (1.644, 1.624), 0.017, 3.06, f"{guide}: indices and dispersion of elbaite")
    yield _printed(
        "zircon", (1.925, 1.984), 0.039, 4.70,
        "O'Donoghue, Gems, 6th ed. (2006): indices and dispersion of high zircon",
    )  # fmt: skip
    yield _printed(
        "topaz", (1.619, 1.621, 1.627), 0.014, 3.53,
        f"{guide}: least and greatest index, and dispersion; 2V: Deer, Howie & Zussman (1982)",
        "middle index chosen, for a 2V of 60 degrees among those of 48 to 68",
    )  # fmt: skip
    yield _printed(
        "peridot", (1.654, 1.671, 1.690), 0.020, 3.34,
        f"{guide}: least and greatest index, and dispersion",
        "middle index chosen, near halfway as the guide says",
    )  # fmt: skip
    yield _printed(
        "tanzanite", (1.692, 1.693, 1.700), 0.021, 3.35,
        f"O'Donoghue, Gems, 6th ed. (2006): indices; {guide}: dispersion",
    )  # fmt: skip


def _pair(formula: str, *coefficients: tuple[object, ...]) -> tuple[Dispersion, ...]:
    return tuple(Formula(formula=formula, coefficients=each) for each in coefficients)


def _loiko(a: float, b: float, c: float, d: float) -> Formula:
    """Return n^2 = a + b L^2 / (L^2 - c) + d L^2 as the pole that it is."""
    return Formula(formula="pole", coefficients=(a + b, b * c, c, d))


def _material(
    name: str, indices: tuple[Dispersion, ...], range_nm: tuple[float, float], density: float,
    source: str, note: str = "",
) -> Material:  # fmt: skip
    about = _UNIAXIAL if len(indices) == 2 else _BIAXIAL
    return Material.of_crystal(
        Crystal(dispersions=indices),
        name=name,
        range_nm=range_nm,
        density=density,
        source=source,
        note="; ".join(part for part in (about, note) if part),
    )


def _printed(
    name: str, at_sodium: tuple[float, ...], b_g: float, density: float, source: str, note: str = ""
) -> Material:
    """Make a material of its indices at the sodium line and its dispersion from B to G."""
    indices = tuple(_cauchy(n_d, b_g) for n_d in at_sodium)
    note = "; ".join(part for part in (note, _ONE_DISPERSION) if part)
    return _material(name, indices, _B_TO_G_NM, density, source, note)


def _cauchy(n_d: float, b_g: float) -> Formula:
    """Return n = A + B / L^2 with an index at the sodium line, and a dispersion."""
    b = round(b_g / (_G_UM**-2 - _B_UM**-2), 6)
    return Formula(formula="cauchy", coefficients=(round(n_d - b / (SODIUM_NM / 1000) ** 2, 5), b))
