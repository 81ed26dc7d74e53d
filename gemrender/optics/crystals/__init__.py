"""Optics of birefringent crystals: modes, boundaries, energies, absorption. Needs numpy only.

Units: wave vectors in omega / c (their length is the index), H in E over the impedance of vacuum, time as
exp(-i omega t). Normals point out of the crystal; directions are in the stone's frame, table up.
"""

from __future__ import annotations

from gemrender.optics.crystals.boundary import Entering, Leaving, enter, leave
from gemrender.optics.crystals.crystal import Crystal, absorption_per_mm
from gemrender.optics.crystals.frame import frame_of_angles, frame_of_axes, frame_of_c_axis
from gemrender.optics.crystals.indicatrix import Indicatrix, optic_axes, optic_axial_angle_deg
from gemrender.optics.crystals.modes import Modes, modes_along
from gemrender.optics.crystals.shares import SharesEntering, SharesInside, shares_entering, shares_inside
from gemrender.optics.crystals.waves import Waves, boundary_axes, boundary_waves

__all__ = [
    "Crystal",
    "Entering",
    "Indicatrix",
    "Leaving",
    "Modes",
    "SharesEntering",
    "SharesInside",
    "Waves",
    "absorption_per_mm",
    "boundary_axes",
    "boundary_waves",
    "enter",
    "frame_of_angles",
    "frame_of_axes",
    "frame_of_c_axis",
    "leave",
    "modes_along",
    "optic_axes",
    "optic_axial_angle_deg",
    "shares_entering",
    "shares_inside",
]
