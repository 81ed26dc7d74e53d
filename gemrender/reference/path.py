"""Single rays in full: every surface that a ray meets on its way through the stone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.observation import Model, RayStatus, View
from gemrender.reference.tracer import START_DISTANCE, trace
from gemrender.stone import Stone

__all__ = ["RayPath", "full_paths"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RayPath:
    """One ray from the eye back through the stone, as the reference tracer scores it.

    Attributes
    ----------
    x, y : float
        Where the ray stands in the view [girdle radius].
    points : (k, 3) float64
        Where it enters, is reflected and leaves [girdle radius]; empty if it misses the stone.
    facets : (k,) int64
        Facet at each point.
    facet_names : tuple of str
        Its name.
    normals : (k, 3) float64
        Outward unit normals there.
    directions : (k + 1, 3) float64
        Unit directions of the ray followed back: towards the stone, between the points, and beyond the last
        one. The light runs the other way.
    status : RayStatus
    reflections : int
    primary_intensity : float
        Intensity by the model [%].
    rear : bool
        Whether its light is rear light.
    """

    x: float
    y: float
    points: np.ndarray
    facets: np.ndarray
    facet_names: tuple[str, ...]
    normals: np.ndarray
    directions: np.ndarray
    status: RayStatus
    reflections: int
    primary_intensity: float
    rear: bool

    @property
    def incidence_deg(self) -> np.ndarray:
        """(k,) angle between the ray that arrives at each point and the normal there [deg]."""
        cos = np.einsum("ij,ij->i", self.directions[: len(self.points)], self.normals)
        return np.asarray(np.degrees(np.arccos(np.clip(np.abs(cos), 0.0, 1.0))))


def full_paths(
    stone: Stone, points: np.ndarray, *, view: View | None = None, model: Model | None = None
) -> list[RayPath]:
    """Trace the rays through points of a view, and keep their whole paths.

    Parameters
    ----------
    stone : Stone
        The stone.
    points : (n, 2) array_like
        x and y in the view [girdle radius].
    view : View, optional
        Where the eye is; by default straight above. Its resolution does not matter.
    model : Model, optional
        The optical model; by default that of the stone's material.

    Returns
    -------
    list of n RayPath
    """
    xy = np.atleast_2d(np.asarray(points, dtype=np.float64))
    right, up, eye = (view or View(resolution=1)).basis()
    origin = xy[:, :1] * right + xy[:, 1:] * up + START_DISTANCE * eye
    direction = np.broadcast_to(-eye, origin.shape)
    met: list[list[tuple[np.ndarray, ...]]] = [[] for _ in xy]

    def on_surface(ray: np.ndarray, *values: np.ndarray) -> None:
        for i, number in enumerate(ray):
            met[number].append(tuple(value[i] for value in values))

    record = trace(stone, origin, direction, model or Model.of(stone), on_surface=on_surface)
    paths = []
    for i, surfaces in enumerate(met):
        at, facets, normals, _, after = zip(*surfaces, strict=True) if surfaces else ((),) * 5
        paths.append(
            RayPath(
                x=float(xy[i, 0]),
                y=float(xy[i, 1]),
                points=np.reshape(at, (-1, 3)),
                facets=np.array(facets, dtype=np.int64),
                facet_names=tuple(stone.facets[facet].name for facet in facets),
                normals=np.reshape(normals, (-1, 3)),
                directions=np.concatenate([direction[i : i + 1], np.reshape(after, (-1, 3))]),
                status=RayStatus(int(record.status[i])),
                reflections=int(record.reflections[i]),
                primary_intensity=float(record.primary_intensity[i]),
                rear=bool(record.rear_mask[i]),
            )
        )
    return paths
