"""The sensor ``gem_orthographic``: parallel rays for the top view of a stone."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.plugins.properties import choice, number

_NUMBERS = {
    "x_min": -1.0,
    "x_max": 1.0,
    "y_min": -1.0,
    "y_max": 1.0,
    "tilt": 0.0,
    "tilt_azimuth": 0.0,
    "distance": 10.0,
}
_SAMPLINGS = ("centre", "area")


class OrthographicSensor(mi.Sensor):
    r"""
    .. _sensor-gem_orthographic:

    Orthographic sensor over a stone (:monosp:`gem_orthographic`)
    -------------------------------------------------------------

    .. pluginparameters::

     * - x_min, x_max, y_min, y_max
       - |float|
       - The window of the view plane that the film covers [girdle radii]: the minimum has to lie below the
         maximum. (Default: -1, 1, -1, 1)
       - |exposed|

     * - tilt
       - |float|
       - Angle between the :math:`z` axis and the direction to the eye [degrees], at least 0 and below 90.
         (Default: 0, straight from above)
       - |exposed|

     * - tilt_azimuth
       - |float|
       - The azimuth, counted from the :math:`x` axis towards the :math:`y` axis, that the tilt moves the eye
         towards [degrees]. (Default: 0)
       - |exposed|

     * - distance
       - |float|
       - How far from the origin the rays start [girdle radii], more than 1. What lies behind that plane is
         not seen. Keep it moderate: rays are traced in single precision. (Default: 10)
       - |exposed|

     * - sampling
       - |string|
       - :monosp:`centre` sends every sample of a pixel through the centre of its cell; :monosp:`area` sends
         it where the sampler puts it, so that samples spread over the cell. (Default: :monosp:`centre`)

     * - srf
       - |spectrum|
       - Sensor response function, in spectral variants only, as in Mitsuba's own sensors.
         (Default: none)

    This sensor looks at a stone that lies in its own frame: the :math:`z` axis points up, through the table,
    and the girdle has radius 1. The eye is far away in the direction

    .. math::

        e = (\sin\theta \cos\phi, \; \sin\theta \sin\phi, \; \cos\theta),

    with the tilt :math:`\theta` and its azimuth :math:`\phi`, and all rays run along :math:`-e`. Right and up
    in the image are the :math:`x` and the :math:`y` axis, turned by the same rotation that turns the
    :math:`z` axis into :math:`e`; with no tilt the image shows :math:`x` to the right and :math:`y` up, as
    Mitsuba's :monosp:`orthographic` does when it looks at the origin from above.

    A film of :math:`W \times H` pixels divides the window into as many cells. The pixel in column :math:`i`
    and row :math:`j`, both counted from 0 at the top left, is the cell with its centre at

    .. math::

        x = x_\mathrm{min} + (i + 1/2) \, (x_\mathrm{max} - x_\mathrm{min}) / W, \qquad
        y = y_\mathrm{max} - (j + 1/2) \, (y_\mathrm{max} - y_\mathrm{min}) / H.

    Cells need not be square. The window is that of the whole film; a crop window takes its part of it.

    To render in passes, move the window: the parameters marked as exposed are kept out of the compiled
    kernel, so a change of them costs no new one. Place the view by :monosp:`tilt`; there is no
    :monosp:`to_world`.

    .. note::

        Mitsuba adds the sample's place in the pixel to the number of the pixel in single precision. On a film
        of a thousand pixels across, one random sample in some ten thousand is rounded into the next pixel,
        and :monosp:`centre` then takes the centre of that one's cell. Maps that need each cell exactly once
        take a box filter and the sampler of the example, which samples the middle of each pixel.

    .. tabs::
        .. code-tab:: xml

            <sensor type="gem_orthographic">
                <float name="x_min" value="-1.05"/>
                <float name="x_max" value="1.05"/>
                <float name="y_min" value="-1.05"/>
                <float name="y_max" value="1.05"/>
                <float name="tilt" value="10"/>
                <string name="sampling" value="centre"/>
                <film type="hdrfilm">
                    <integer name="width" value="512"/>
                    <integer name="height" value="512"/>
                    <string name="pixel_format" value="luminance"/>
                    <string name="component_format" value="float32"/>
                    <rfilter type="box"/>
                </film>
                <sampler type="stratified">
                    <integer name="sample_count" value="1"/>
                    <boolean name="jitter" value="false"/>
                </sampler>
            </sensor>

        .. code-tab:: python

            'type': 'gem_orthographic',
            'x_min': -1.05, 'x_max': 1.05,
            'y_min': -1.05, 'y_max': 1.05,
            'tilt': 10,
            'sampling': 'centre',
            'film': {
                'type': 'hdrfilm',
                'width': 512, 'height': 512,
                'pixel_format': 'luminance', 'component_format': 'float32',
                'rfilter': {'type': 'box'},
            },
            'sampler': {'type': 'stratified', 'sample_count': 1, 'jitter': False},

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.m_needs_sample_3 = False  # no aperture; else each ray draws two numbers in vain
        if "to_world" in props:  # the base class takes it from every sensor, and would ignore it
            raise InputError("not allowed here, place the view by tilt and tilt_azimuth", key="to_world")
        for key, default in _NUMBERS.items():
            setattr(self, key, mi.Float(number(props, key, default)))
        self.sampling = choice(props, "sampling", _SAMPLINGS)
        self._update()

    def _update(self) -> None:
        """Check the parameters; derive from them, in double precision, what the rays are made of."""
        x_min, x_max, y_min, y_max, tilt, tilt_azimuth, distance = (getattr(self, key)[0] for key in _NUMBERS)
        for axis, low, high in (("x", x_min, x_max), ("y", y_min, y_max)):
            if not -math.inf < low < high < math.inf:
                raise InputError(f"must be below {axis}_max = {high:g}", key=f"{axis}_min", value=low)
        if not 0 <= tilt < 90:
            raise InputError("must be at least 0 and below 90 degrees", key="tilt", value=tilt)
        if not math.isfinite(tilt_azimuth):
            raise InputError("must be a finite number", key="tilt_azimuth", value=tilt_azimuth)
        if not 1 < distance < math.inf:
            raise InputError("must be more than 1 (the girdle's radius)", key="distance", value=distance)

        # The rotation by the tilt about the axis (-sin, cos, 0) of its azimuth (Rodrigues' formula).
        sin_t, cos_t = math.sin(math.radians(tilt)), math.cos(math.radians(tilt))
        sin_a, cos_a = math.sin(math.radians(tilt_azimuth)), math.cos(math.radians(tilt_azimuth))
        self._right = mi.Vector3f(
            cos_t + sin_a * sin_a * (1 - cos_t), -sin_a * cos_a * (1 - cos_t), -sin_t * cos_a
        )
        self._up = mi.Vector3f(
            -sin_a * cos_a * (1 - cos_t), cos_t + cos_a * cos_a * (1 - cos_t), -sin_t * sin_a
        )
        # Subtracted from zero, not negated: straight down is (0, 0, -1) without negative zeros.
        self._direction = mi.Vector3f(0.0 - sin_t * cos_a, 0.0 - sin_t * sin_a, 0.0 - cos_t)

        width, height = self.film().size()
        self._centre = mi.Point2f((x_min + x_max) / 2, (y_min + y_max) / 2)
        self._cell = mi.Vector2f((x_max - x_min) / width, (y_max - y_min) / height)

        # Literals would be compiled into the kernel, a new one for each value.
        dr.make_opaque(
            [getattr(self, key) for key in _NUMBERS],
            self._right,
            self._up,
            self._direction,
            self._centre,
            self._cell,
        )

    def _origin(self, sample: mi.Point2f) -> mi.Point3f:
        """Return where the ray starts for a sample's position in the crop window, (0, 0) to (1, 1)."""
        film = self.film()
        pixel = sample * mi.Vector2f(film.crop_size())
        if self.sampling == "centre":
            pixel = dr.floor(pixel) + 0.5
        # Counted from the middle of the film, a symmetric window has exactly symmetric cells.
        pixel += mi.Vector2f(film.crop_offset()) - 0.5 * mi.Vector2f(film.size())
        x = dr.fma(pixel.x, self._cell.x, self._centre.x)
        y = dr.fma(-pixel.y, self._cell.y, self._centre.y)
        return mi.Point3f(x * self._right + y * self._up - self.distance * self._direction)

    def sample_ray(
        self,
        time: mi.Float,
        sample1: mi.Float,
        sample2: mi.Point2f,
        sample3: mi.Point2f,
        active: mi.Bool = True,
    ) -> tuple[mi.Ray3f, mi.Spectrum]:
        """Return the ray through the film at `sample2`, and its weight."""
        interaction = dr.zeros(mi.SurfaceInteraction3f)
        wavelengths, weight = self.sample_wavelengths(interaction, sample1, active)
        return mi.Ray3f(self._origin(sample2), self._direction, time, wavelengths), weight

    def sample_ray_differential(
        self,
        time: mi.Float,
        sample1: mi.Float,
        sample2: mi.Point2f,
        sample3: mi.Point2f,
        active: mi.Bool = True,
    ) -> tuple[mi.RayDifferential3f, mi.Spectrum]:
        """Return the same as `sample_ray`, with the rays of the next column and the next row."""
        ray, weight = self.sample_ray(time, sample1, sample2, sample3, active)
        ray = mi.RayDifferential3f(ray)
        ray.o_x = ray.o + self._cell.x * self._right
        ray.o_y = ray.o - self._cell.y * self._up
        ray.d_x = ray.d
        ray.d_y = ray.d
        ray.has_differentials = True
        return ray, weight

    def bbox(self) -> mi.ScalarBoundingBox3f:
        """Return the point that the middle of the bundle starts from, as Mitsuba's orthographic does."""
        point = mi.ScalarPoint3f([-self.distance[0] * component[0] for component in self._direction])
        return mi.ScalarBoundingBox3f(point, point)

    def traverse(self, callback: mi.TraversalCallback) -> None:
        """Expose the window, the tilt and the distance."""
        super().traverse(callback)
        for key in _NUMBERS:
            callback.put(key, getattr(self, key), mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: list[str]) -> None:
        """Take over changed parameters."""
        super().parameters_changed(keys)
        self._update()

    def to_string(self) -> str:
        """Describe the sensor in Mitsuba's manner."""
        numbers = "".join(f"  {key} = {getattr(self, key)[0]:g},\n" for key in _NUMBERS)
        film = str(self.film()).replace("\n", "\n  ")
        return f"OrthographicSensor[\n{numbers}  sampling = {self.sampling},\n  film = {film}\n]"


mi.register_sensor("gem_orthographic", OrthographicSensor)
