"""What looks dark: `extinction`, light from the viewer's head, and light that leaks after several hits."""

from __future__ import annotations

import numpy as np

from gemrender.measures.measure import Light, Measure, in_columns, is_above, is_tied

__all__ = ["Extinction"]


class Extinction(Measure):
    """Shares of the view that reflect the viewer's head, or leak late."""

    name, version = "extinction", 1
    definition = (
        "shares of the view whose principal light comes from the viewer's head (d > cos h, h = 10 deg), or "
        "leaks (d <= 0) at the second hit or later (late_leak); d the cosine with the viewer's zenith; what "
        "is within 1e-7 of a limit counts as outside head and sky, and `tied`"
    )
    source = "gemrender"
    keys = ("head", "late_leak", "tied")
    follow = "principal"
    smooth_keys = keys
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return 1 for what comes from the head, leaks late, and is tied, (n, 3), else 0."""
        d, exits = light.zenith_cosine, light.is_principal & light.is_exit
        late = exits & (light.paths.reflections >= 1)
        return in_columns(
            exits & is_above(d, light.head_cosine),
            late & ~is_above(d, 0.0),
            (exits & is_tied(d, light.head_cosine)) | (late & is_tied(d, 0.0)),
        )
