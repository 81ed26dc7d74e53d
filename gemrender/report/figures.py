"""Pictures of scored maps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.observation import Observation, RayStatus
from gemrender.report.tables import band_name
from gemrender.score import BAND_EDGES, score_observation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["BAND_COLOURS", "map_figure", "write_map_figure"]

#: Colours of the bands, brightest first: steps of viridis, even in lightness and safe for colour-blind eyes.
BAND_COLOURS = ("#fde725", "#9bd93c", "#35b779", "#21908c", "#31688e", "#443983")
#: Rear light, and rays that are trapped or lost: apart from the scale.
REAR_COLOUR = "#141414"
UNSOLVED_COLOUR = "#e4572e"
OUTSIDE_COLOUR = "#ffffff"


def map_figure(observation: Observation) -> Figure:
    """Draw the intensity map in its bands, with Average, Rear and the share of each band beside it."""
    from matplotlib.colors import to_rgb
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    result = score_observation(observation)
    figure = Figure(figsize=(8.6, 5.3), dpi=160, layout="constrained")
    axes = figure.subplots()
    half = observation.view.half_width
    axes.imshow(_banded(observation, to_rgb), extent=(-half, half, -half, half), interpolation="antialiased")
    axes.set(aspect="equal", xlim=(-1.02 * half, 1.02 * half), ylim=(-1.02 * half, 1.02 * half))
    axes.set_xlabel("x [girdle radius]")
    axes.set_ylabel("y [girdle radius]")
    axes.set_xticks(np.arange(-1, 1.01, 0.5))
    axes.set_yticks(np.arange(-1, 1.01, 0.5))
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(result.name, loc="left", fontsize=15, fontweight="bold")
    entries = [
        Patch(facecolor=colour, edgecolor="#888888", label=f"{band_name(band)} %:  {band.share:.1f} %")
        for colour, band in zip(BAND_COLOURS, result.bands, strict=True)
    ]
    entries.append(Patch(facecolor=REAR_COLOUR, edgecolor="#888888", label=f"Rear:  {result.rear:.2f} %"))
    unsolved = result.trapped + result.lost
    if unsolved > 0:
        label = f"Trapped:  {unsolved:.2g} %"
        entries.append(Patch(facecolor=UNSOLVED_COLOUR, edgecolor="#888888", label=label))
    kind = "Primary intensity" if result.intensity == "primary" else "Radiance"
    legend = figure.legend(
        handles=entries,
        loc="outside right center",
        frameon=False,
        fontsize=12,
        title=f"Average  {result.average:.2f} %\nRear  {result.rear:.2f} %\n\n{kind}: share of top view",
        title_fontsize=12.5,
        alignment="left",
    )
    legend.get_title().set_multialignment("left")
    return figure


def write_map_figure(observation: Observation, path: Path) -> None:
    """Write the map's figure as PNG."""
    map_figure(observation).savefig(path, format="png")


def _banded(observation: Observation, to_rgb: Any) -> np.ndarray:
    """Return the map as (h, w, 3) colours of its bands."""
    intensity, status = observation.primary_intensity, observation.status
    palette = np.array([to_rgb(c) for c in (*BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR, OUTSIDE_COLOUR)])
    band = np.digitize(intensity, BAND_EDGES[:-1])  # decreasing edges: 0 is the brightest
    n = len(BAND_COLOURS)
    band = np.where(observation.rear_mask > 0, n, band)
    band = np.where((status == RayStatus.TRAPPED) | (status == RayStatus.LOST), n + 1, band)
    band = np.where(status == RayStatus.MISSED, n + 2, band)
    return np.asarray(palette[band])
