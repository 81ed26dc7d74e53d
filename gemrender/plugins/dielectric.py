"""`gem_dielectric`: the smooth surface of a gem, with an index that depends on the wavelength."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.errors import InputError
from gemrender.optics import Material, load_material
from gemrender.optics.material import VISIBLE_NM
from gemrender.optics.principal import along_axes
from gemrender.plugins.properties import crystal_axes, direction, number, truth
from gemrender.plugins.spectra import FIRST_NM, LAST_NM

#: The sodium line, for which stones are scored [nm].
SODIUM_NM = 589.3


class GemDielectric(mi.BSDF):
    r"""
    .. _bsdf-gem_dielectric:

    Surface of a gem (:monosp:`gem_dielectric`)
    -------------------------------------------

    .. pluginparameters::

     * - material
       - |string|
       - Name of a gem material (``gemrender materials`` lists them) or a material file. (Default: diamond)
       -

     * - int_ior
       - |float|
       - Refractive index, instead of a material: without dispersion.
       -

     * - ext_ior
       - |float|
       - Refractive index of what surrounds the stone. (Default: 1.0)
       -

     * - dispersion
       - |bool|
       - Whether the index depends on the wavelength; if not, it is that at 589.3 nm. (Default: true)
       -

     * - wavelength
       - |float|
       - The wavelength whose index counts where the integrator does not ask for others [nm]; see below.
         (Default: 589.3)
       - |exposed|

     * - unit_mm
       - |float|
       - Size of a scene unit, for absorption [mm]. (Default: 1.0)
       -

     * - girdle_alpha
       - |float|
       - Roughness of the girdle, alpha of GGX's distribution; 0 is polished. With ``gem_path`` only.
         (Default: 0)
       -

     * - axis
       - |vector|
       - The stone's axis, table up: the girdle's facets are those across it. (Default: 0, 0, 1)
       -

     * - c_axis
       - |vector|
       - Of a birefringent material the optic axis, in the world; of a biaxial one the axis gamma, of the
         greatest index. With ``gem_path`` only. (Default: 0, 0, 1)
       -

     * - a_axis
       - |vector|
       - Of a biaxial material the axis alpha, of the least index, at right angles to ``c_axis``.
         (Default: any)
       -

     * - birefringence
       - |bool|
       - Whether a birefringent material splits light; if not, it has its ordinary index and absorption, or
         the middle index and mean absorption of a biaxial one. (Default: true)
       -

    A smooth dielectric with unpolarised Fresnel reflectance, whose radiance is scaled by the squared index as
    Mitsuba's own ``dielectric`` does. With ``gem_path``, each wavelength has its own index, and the material
    absorbs on the way. A birefringent material splits light in two, and a pleochroic one absorbs by the
    direction of its field.

    Other integrators take a birefringent material as with ``birefringence`` off. They ask a surface for one
    direction at a time, and a surface cannot know whether the wavelengths of a path have parted before; a
    weight that makes up for those that ended would then count twice. So for them the whole surface has one
    index, that at ``wavelength``: render one wavelength a pass, in a monochrome variant, and sum up the
    passes as a spectrum. The index is held outside the kernel: passes at other wavelengths compile nothing.
    Absorption is left out there: it is no matter of the surface. Nor do they check a scene: meshes must be
    closed and look outwards, with the vertex normals of their faces (``face_normals``).
    ``mi.load_dict({'type': 'gem_path'}).check(scene, sensor)`` tells what is wrong.

    .. tabs::
        .. code-tab:: xml
            :name: gem-dielectric

            <bsdf type="gem_dielectric">
                <string name="material" value="sapphire"/>
            </bsdf>

        .. code-tab:: python

            'type': 'gem_dielectric',
            'material': 'sapphire'

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        if "int_ior" in props:
            if "material" in props:
                raise InputError("needs material or int_ior, not both", key="int_ior", value=props["int_ior"])
            self.material = Material.constant(number(props, "int_ior", 1.5))
        else:
            self.material = load_material(str(props.get("material", "diamond")))
        self.ext_ior = number(props, "ext_ior", 1.0)
        if not 0 < self.ext_ior < 4:
            raise InputError("must be above 0 and below 4", key="ext_ior", value=self.ext_ior)
        self.unit_mm = number(props, "unit_mm", 1.0)
        if not self.unit_mm > 0:
            raise InputError("must be above 0", key="unit_mm", value=self.unit_mm)
        #: Roughness of the girdle, and the stone's axis (3,).
        self.girdle_alpha = number(props, "girdle_alpha", 0.0)
        if not 0 <= self.girdle_alpha <= 1:
            raise InputError("must be from 0 to 1", key="girdle_alpha", value=self.girdle_alpha)
        self.axis = direction(props, "axis", (0.0, 0.0, 1.0))
        self.crystal_axes = crystal_axes(props)
        grid = np.arange(FIRST_NM, LAST_NM + 1, dtype=np.float64)
        of_range = np.clip(grid, *VISIBLE_NM)
        index = self.material.index(of_range)
        sodium = float(self.material.index(SODIUM_NM))
        self.disperses = truth(props, "dispersion", True) and bool(np.ptp(index) > 0)
        #: Relative index on the grid, and absorption coefficient [1/scene unit]; (471,) float32.
        self.index_table = ((index if self.disperses else np.full_like(grid, sodium)) / self.ext_ior).astype(
            np.float32
        )
        absorption = self.material.absorption_per_mm(of_range) * self.unit_mm
        self.absorption_table = absorption.astype(np.float32)
        self.absorbs = bool(absorption.any())
        self._split(truth(props, "birefringence", True), of_range)
        self.wavelength = mi.Float(number(props, "wavelength", SODIUM_NM))
        self._update()
        reflection = mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        transmission = (
            mi.BSDFFlags.DeltaTransmission
            | mi.BSDFFlags.FrontSide
            | mi.BSDFFlags.BackSide
            | mi.BSDFFlags.NonSymmetric
        )
        self.m_components = [reflection, transmission]
        self.m_flags = reflection | transmission

    def _split(self, wanted: bool, of_range: np.ndarray) -> None:
        """Tabulate the index and the absorption of each principal direction."""
        crystal = self.material.crystal if wanted else None
        #: Relative index and absorption coefficient [1/scene unit] along each axis of `crystal_axes` on the
        #: grid; (3, 471) float32. Of a uniaxial crystal the first two are the ordinary ray's.
        self.principal_tables = np.tile(self.index_table, (3, 1))
        self.absorption_tables = np.tile(self.absorption_table, (3, 1))
        if crystal is not None:
            lines = of_range if self.disperses else np.full_like(of_range, SODIUM_NM)
            self.principal_tables = (along_axes(crystal, lines) / self.ext_ior).astype(np.float32)
            if crystal.absorptions:
                absorption = crystal.principal_absorption_per_mm(of_range).T * self.unit_mm
                self.absorption_tables = absorption.astype(np.float32)
                self.absorbs = self.absorbs or bool(absorption.any())
        #: Whether directions differ, in index or absorption.
        self.birefringent = bool(
            np.ptp(self.principal_tables, axis=0).any() or np.ptp(self.absorption_tables, axis=0).any()
        )

    def _update(self) -> None:
        wavelength = self.wavelength[0]
        low, high = VISIBLE_NM
        if not low <= wavelength <= high:
            raise InputError(f"must be from {low:g} to {high:g} [nm]", key="wavelength", value=wavelength)
        index = float(self.material.index(wavelength if self.disperses else SODIUM_NM)) / self.ext_ior
        self.eta = dr.opaque(mi.Float, index)  # a literal would be a kernel of its own

    def traverse(self, cb: mi.TraversalCallback) -> None:
        """Expose the parameter that can change without a new kernel."""
        cb.put("wavelength", self.wavelength, mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: list[str]) -> None:
        """Take over a changed wavelength."""
        self._update()

    def sample(
        self,
        ctx: mi.BSDFContext,
        si: mi.SurfaceInteraction3f,
        sample1: mi.Float,
        sample2: mi.Point2f,
        active: mi.Bool = True,
    ) -> tuple[mi.BSDFSample3f, mi.Spectrum]:
        """Reflect or refract, by chance with Fresnel's shares."""
        reflects_at_all = ctx.is_enabled(mi.BSDFFlags.DeltaReflection, 0)
        transmits_at_all = ctx.is_enabled(mi.BSDFFlags.DeltaTransmission, 1)
        cos_i = mi.Frame3f.cos_theta(si.wi)
        r, cos_t, eta_it, eta_ti = mi.fresnel(cos_i, self.eta)
        if reflects_at_all and transmits_at_all:
            reflected, pdf, weight = sample1 <= r, dr.select(sample1 <= r, r, 1 - r), mi.Float(1)
        elif reflects_at_all or transmits_at_all:
            reflected, pdf = mi.Bool(reflects_at_all), mi.Float(1)
            weight = r if reflects_at_all else 1 - r
        else:
            return dr.zeros(mi.BSDFSample3f), mi.Spectrum(0)
        reflected = active & reflected
        bs = dr.zeros(mi.BSDFSample3f)
        bs.wo = dr.select(reflected, mi.reflect(si.wi), mi.refract(si.wi, cos_t, eta_ti))
        bs.pdf = dr.select(active, pdf, 0)
        bs.eta = dr.select(reflected, 1, eta_it)
        bs.sampled_component = dr.select(reflected, mi.UInt32(0), 1)
        bs.sampled_type = dr.select(
            reflected, mi.UInt32(+mi.BSDFFlags.DeltaReflection), +mi.BSDFFlags.DeltaTransmission
        )
        if ctx.mode == mi.TransportMode.Radiance:
            # Radiance changes with the squared index where a beam narrows or widens
            weight = weight * dr.select(reflected, 1, dr.square(eta_ti))
        return bs, mi.Spectrum(dr.select(active, weight, 0))

    def eval(
        self, ctx: mi.BSDFContext, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, active: mi.Bool = True
    ) -> mi.Spectrum:
        """Return 0: no direction but the two is met."""
        return mi.Spectrum(0)

    def pdf(
        self, ctx: mi.BSDFContext, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, active: mi.Bool = True
    ) -> mi.Float:
        """Return 0: no direction but the two is met."""
        return mi.Float(0)

    def eval_pdf(
        self, ctx: mi.BSDFContext, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, active: mi.Bool = True
    ) -> tuple[mi.Spectrum, mi.Float]:
        """Return 0 and 0."""
        return mi.Spectrum(0), mi.Float(0)

    def eval_diffuse_reflectance(self, si: mi.SurfaceInteraction3f, active: mi.Bool = True) -> mi.Spectrum:
        """Return 1, as denoisers expect of glass."""
        return mi.Spectrum(1)

    def to_string(self) -> str:
        """Describe the surface in Mitsuba's manner."""
        return (
            f"GemDielectric[\n  material = {self.material.name},\n  ext_ior = {self.ext_ior:g},\n"
            f"  wavelength = {self.wavelength[0]:g},\n  dispersion = {self.disperses},\n"
            f"  birefringence = {self.birefringent},\n  unit_mm = {self.unit_mm:g}\n]"
        )


mi.register_bsdf("gem_dielectric", lambda props: GemDielectric(props))
