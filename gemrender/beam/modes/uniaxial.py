"""The waves of a uniaxial crystal at a facet, compiled: in closed form.

Lekner, J. Phys.: Condens. Matter 3, 6121 (1991), here in vectors. With the optic axis c and
k = (c . k) c + p the ordinary wave has k^2 = eps_o and E along c x p, and the extraordinary one
E = (eps_o / eps_e) p^2 c - (c . k) p.
"""

from __future__ import annotations

import math
from typing import Any

from gemrender.beam.compiled import jit_inner
from gemrender.beam.modes.waves import BACK, OUT, norm2, root_of, write_field

__all__ = ["write_uniaxial"]

#: Sine of the angle to the optic axis below which the extraordinary wave is found from the ordinary one.
_NEAR_AXIS = 0.03
#: The same from which on the two modes are taken as one wave, of any two fields at right angles: rounding of
#: wave vectors must not tell these apart, each mode by itself.
_ON_AXIS = 1e-12


@jit_inner
def _towards(
    px: complex, py: complex, pz: complex, size: float, ordinary: float, fx: float, fy: float, fz: float
) -> Any:
    """Return p as a unit vector; along the optic axis, where it is none, the crystal's first axis."""
    if size < _ON_AXIS * math.sqrt(ordinary):
        return complex(fx), complex(fy), complex(fz)
    by = 1.0 / size
    return px * by, py * by, pz * by


@jit_inner
def write_uniaxial(crystal: Any, kappa: float, waves: Any) -> None:
    """Write the waves of a uniaxial crystal: of each pair first the ordinary one."""
    axes, c, f = waves.axes, crystal.axis, crystal.first
    cx = axes[0, 0] * c[0] + axes[0, 1] * c[1] + axes[0, 2] * c[2]
    cy = axes[1, 0] * c[0] + axes[1, 1] * c[1] + axes[1, 2] * c[2]
    cn = axes[2, 0] * c[0] + axes[2, 1] * c[1] + axes[2, 2] * c[2]
    fx = axes[0, 0] * f[0] + axes[0, 1] * f[1] + axes[0, 2] * f[2]
    fy = axes[1, 0] * f[0] + axes[1, 1] * f[1] + axes[1, 2] * f[2]
    fn = axes[2, 0] * f[0] + axes[2, 1] * f[1] + axes[2, 2] * f[2]
    eo, ee = crystal.ordinary, crystal.extraordinary
    difference = ee - eo
    e_nn = eo + difference * cn * cn
    square = ee * e_nn - kappa * kappa * (eo + difference * (cx * cx + cn * cn))
    root, k_root = root_of(eo * square), root_of(eo - kappa * kappa)
    # What x and n have across the optic axis, without cancellation
    xx, xy, xn = kappa * (cy * cy + cn * cn), -kappa * cx * cy, -kappa * cx * cn
    ax, ay, an = -cn * cx, -cn * cy, cx * cx + cy * cy
    least = min(
        norm2(xx + k_root * ax, xy + k_root * ay, xn + k_root * an),
        norm2(xx - k_root * ax, xy - k_root * ay, xn - k_root * an),
    )
    near = k_root.imag == 0.0 and least < _NEAR_AXIS * _NEAR_AXIS * eo
    for pair in range(2):
        side = 1.0 if pair == 0 else -1.0
        k_o, flow_e = side * k_root, side * root  # flow_e is (eps k)_n of the extraordinary wave
        px, py, pn = xx + k_o * ax, xy + k_o * ay, xn + k_o * an
        along = px * cx + py * cy + pn * cn  # what rounding left
        px, py, pn = px - along * cx, py - along * cy, pn - along * cn
        if near:
            # Next to the axis the two wave vectors part by next to nothing, which keeps all digits here:
            # e_nn step^2 + 2 (eps k_o)_n step = (eps_e - eps_o) p^2
            flow = eo * k_o + difference * cn * (kappa * cx + k_o * cn)
            rise = difference * (px * px + py * py + pn * pn)
            inner = flow * flow + e_nn * rise
            flow_e = side * root_of(inner.real)
            step = rise / (flow + flow_e) if (flow * flow_e).real > 0.0 else (flow_e - flow) / e_nn
            k_e = k_o + step
            qx, qy, qn = px + step * ax, py + step * ay, pn + step * an
        else:
            k_e = (flow_e - difference * cn * cx * kappa) / e_nn
            qx, qy, qn = xx + k_e * ax, xy + k_e * ay, xn + k_e * an
            along = qx * cx + qy * cy + qn * cn
            qx, qy, qn = qx - along * cx, qy - along * cy, qn - along * cn
        i = OUT if pair == 0 else BACK
        tx, ty, tn = _towards(px, py, pn, math.sqrt(norm2(px, py, pn)), eo, fx, fy, fn)
        waves.k[i], waves.flux[i] = k_o, k_o.real
        write_field(kappa, i, cy * tn - cn * ty, cn * tx - cx * tn, cx * ty - cy * tx, waves)
        size = math.sqrt(norm2(qx, qy, qn))
        tx, ty, tn = _towards(qx, qy, qn, size, eo, fx, fy, fn)
        on_c = eo / ee * size * (tx * tx + ty * ty + tn * tn)
        by = kappa * cx + k_e * cn
        ex, ey, en = on_c * cx - by * tx, on_c * cy - by * ty, on_c * cn - by * tn
        power = norm2(ex, ey, en)
        unit = 1.0 / math.sqrt(power)
        waves.k[i + 1], waves.flux[i + 1] = k_e, eo / ee * flow_e.real / power
        write_field(kappa, i + 1, ex * unit, ey * unit, en * unit, waves)
