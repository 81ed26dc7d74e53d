"""Where a camera sees a place, and what light from there counts in its picture."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

__all__ = ["Projection"]

#: Directions, and places relative to their size, that are the same up to rounding.
_SAME = 1e-5


class Projection:
    """The inverse of a camera: from a place in the scene to its place in the film.

    It is told by the camera's own rays through three corners of the film, which is flat and has straight
    edges: either all rays are parallel, or they meet in a point, the middle of the lens.

    Let a flux P (of a wavelength) be reflected at a place towards the camera with the value f cos of the
    surface. The mean over the film of the radiance seen is then P f cos times

    - 1 / A of parallel rays, where A is the film's area across them;
    - 1 / (r^2 A cos^3 t) where they meet at distance r, the ray's angle with the axis is t, and A is the
      film's area at distance 1: dA of the film is cos^-3 t of a solid angle, and that is cos / r^2 of the
      surface's area (Pharr, Jakob and Humphreys, Physically Based Rendering, 3rd ed., 16.1.1). Of a thin
      lens this holds for each place on it.

    Parameters
    ----------
    sensor : mi.Sensor
        The camera.

    Raises
    ------
    ValueError
        Rays of another kind.
    """

    def __init__(self, sensor: mi.Sensor) -> None:
        places = mi.Point2f([0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0])
        ray, _ = sensor.sample_ray(mi.Float(0), mi.Float(0.5), places, mi.Point2f(0.5))
        o, d = (np.zeros((3, 4)) + np.array(x, dtype=np.float64) for x in (ray.o, ray.d))
        o, d = o.T, d.T
        params = mi.traverse(sensor)
        keys = {key for key, _ in params}
        self.aperture = float(params["aperture_radius"][0]) if "aperture_radius" in keys else 0.0
        self.parallel = bool(np.abs(d - d[0]).max() < _SAME)
        matrix = np.array(sensor.world_transform().matrix, dtype=np.float64).reshape(4, 4)
        if self.parallel:
            right, up, axis = o[1] - o[0], o[2] - o[0], d[0]
            if not np.allclose(o[3], o[0] + right + up, atol=_SAME * np.linalg.norm(right + up)):
                raise ValueError(type(sensor).__name__)
            # Film coordinates of a place: what is across the axis, by the two edges
            inverse = np.linalg.inv(np.column_stack([right, up, axis]))
            area = abs(float(np.cross(right, up) @ axis))
            self._numbers = _opaque([*o[0], *inverse.ravel(), *axis, 1 / area])
            return
        frame = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
        middle = matrix[:3, 3]
        local = d @ frame
        slopes = local[:, :2] / local[:, 2:]
        beside = np.linalg.norm(np.cross(o - middle, d), axis=1)
        straight = np.allclose(slopes[3], slopes[1] + slopes[2] - slopes[0], atol=_SAME)
        upright = abs(slopes[1, 1] - slopes[0, 1]) < _SAME and abs(slopes[2, 0] - slopes[0, 0]) < _SAME
        size = max(float(np.abs(o).max()), 1e-3)
        if not (straight and upright and (beside < _SAME * size).all() and (local[:, 2] > 0).all()):
            raise ValueError(type(sensor).__name__)
        span = np.array([slopes[1, 0] - slopes[0, 0], slopes[2, 1] - slopes[0, 1]])
        focus = float(params["focus_distance"][0]) if self.aperture > 0 else 1.0
        area = abs(float(span[0] * span[1]))
        self._numbers = _opaque([*middle, *frame.ravel(), *slopes[0], *span, 1 / area, self.aperture, focus])

    def connect(
        self, p: mi.Point3f, sample: mi.Point2f
    ) -> tuple[mi.Point2f, mi.Vector3f, mi.Float, mi.Float]:
        """Return how a place is seen.

        Parameters
        ----------
        p : Point3f
            The place.
        sample : Point2f
            For the place on the lens.

        Returns
        -------
        (place, direction, distance, importance)
            Place in the film, (0, 0) to (1, 1) within it; direction to the camera, and the way to it; and
            what a flux that is reflected so counts in the mean over the film, see the class: 0 where it is
            behind the camera.
        """
        x = self._numbers
        o = mi.Point3f(*x[:3])
        if self.parallel:
            to = p - o
            u, v, along = (dr.dot(mi.Vector3f(*x[3 + 3 * k : 6 + 3 * k]), to) for k in range(3))
            axis, per_area = mi.Vector3f(*x[12:15]), x[15]
            return mi.Point2f(u, v), -axis, along, dr.select(along > 0, per_area, 0)
        # Columns of the frame are the camera's axes
        axes = [mi.Vector3f(x[3 + k], x[6 + k], x[9 + k]) for k in range(3)]
        corner, span, per_area, aperture, focus = x[12:14], x[14:16], x[16], x[17], x[18]
        to = p - o
        local = mi.Vector3f(*(dr.dot(axis, to) for axis in axes))
        slope = mi.Point2f(local.x, local.y) / local.z
        lens = mi.Point3f(o)
        if self.aperture > 0:
            on_lens = aperture * mi.warp.square_to_uniform_disk_concentric(sample)
            lens = o + on_lens.x * axes[0] + on_lens.y * axes[1]
            # Where the ray from the lens through the place meets the plane that is sharp
            sharp = on_lens + (mi.Point2f(local.x, local.y) - on_lens) * (focus / local.z)
            slope = sharp / focus
        place = mi.Point2f((slope.x - corner[0]) / span[0], (slope.y - corner[1]) / span[1])
        away = lens - p
        distance = dr.norm(away)
        d = away / distance
        cos = -dr.dot(d, axes[2])
        importance = per_area / (dr.square(distance) * cos * dr.square(cos))
        return place, d, distance, dr.select((local.z > 0) & (cos > 0), importance, 0)

    def density(self, p: mi.Point3f, n: mi.Normal3f) -> mi.Float:
        """Return how densely one ray, uniform over the film, meets a surface [1/area]; n is its normal.

        Of a thin lens, from its middle.
        """
        _, d, _, importance = self.connect(p, mi.Point2f(0.5))
        return importance * dr.abs(dr.dot(n, d))

    def typical(self, p: np.ndarray) -> float:
        """Return the importance of a place that is seen in the middle of the picture, p (3,)."""
        if self.parallel:
            return float(self._numbers[15][0])
        to = np.array([x[0] for x in self._numbers[:3]], dtype=np.float64) - p
        return float(self._numbers[16][0]) / max(float(to @ to), 1e-6)


def _opaque(values: list[float]) -> list[mi.Float]:
    return [dr.opaque(mi.Float, float(x)) for x in values]
