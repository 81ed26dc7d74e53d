'use strict';

// The paper's tracer in float64: gemrender/reference/surfaces.py and tracer.py, one ray at a time and with the
// same rules, so that the path shown is the path that was scored. Lengths in the stone's unit, angles in degrees.
//
// A stone comes as the report embeds it:
//
//     planes            [x, y, z, offset] of each: outward unit normal; a point p of it has normal . p = offset
//     planeFacet        the facet that each plane belongs to
//     round             whether the girdle is the upright cylinder of radius 1; it then is the last facet
//     mesh              null; of a stone that is not convex {vertices, triangles}, a plane for each triangle
//     model             {index, fresnel, rear, intensity, maxReflections}
//     view              {basis}: the map's right, its up, and the direction to the eye
//
// and what is the same for every stone:
//
//     gubelinAngles, gubelinReflected     Gübelin's table [deg, share]
//     leastTotal                          n^2 sin^2(theta) from which on all light is reflected
//     level                               a facet whose normal falls by no more is level

const GemTracer = (() => {
    /** Slack of the tests of edges and distances: some thousand roundings of float64. */
    const EDGE_TOLERANCE = 1e-11;
    /** How far a ray that slips between two triangles may pass one by. */
    const SLIP = 1e-6;
    /** Where rays begin, outside every stone. */
    const START_DISTANCE = 10;
    const LIGHT_LEVEL = 100;

    const STATUS = Object.freeze({ MISSED: 0, EXITED: 1, TRAPPED: 2, LOST: 3 });

    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const cross = (a, b) => [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    const along = (p, t, d) => [p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]];
    const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
    const unit = (a) => scaled(a, 1 / Math.sqrt(dot(a, a)));
    const degrees = (cos) => (Math.acos(Math.min(Math.max(cos, -1), 1)) * 180) / Math.PI;

    // ---- Where a ray meets the stone (reference/surfaces.py) -------------------------------------------

    /** Distances at which a ray enters and leaves the cylinder of radius 1; [Infinity, -Infinity] for a miss. */
    function cylinder(origin, direction) {
        const a = direction[0] ** 2 + direction[1] ** 2;
        const b = origin[0] * direction[0] + origin[1] * direction[1];
        const c = origin[0] ** 2 + origin[1] ** 2 - 1;
        const isWithin = c <= EDGE_TOLERANCE;
        if (a === 0) return isWithin ? [-Infinity, Infinity] : [Infinity, -Infinity];
        const root = Math.sqrt(b * b - a * c);
        // On the wall itself rounding may put a ray just outside; inside it meets the wall where it stands.
        if (Number.isNaN(root)) return isWithin ? [-Infinity, 0] : [Infinity, -Infinity];
        return [(-b - root) / a, (-b + root) / a];
    }

    /**
     * A convex solid. The surface that a ray leaves through is the nearest that it runs towards, and the one it
     * enters through the farthest that it runs against: no edge can be slipped through.
     */
    class Planes {
        constructor({ planes, planeFacet, round }) {
            Object.assign(this, { planes, planeFacet, isRound: round });
            this.wallFacet = Math.max(...planeFacet) + 1;
            this.flat = Float64Array.from(planes.flat());
        }

        /** The nearest surface that a ray goes out through, or comes in through; null if it meets none. */
        nearest(origin, direction, inside) {
            const [enter, leave] = this.isRound ? cylinder(origin, direction) : [-Infinity, Infinity];
            const [px, py, pz] = origin;
            const [dx, dy, dz] = direction;
            const { flat } = this;
            let [last, lastPlane, first, firstPlane] = [Infinity, -1, -Infinity, -1];
            // One loop without calls: maps of tilted views trace a hundred thousand rays.
            for (let at = 0, i = 0; at < flat.length; at += 4, i++) {
                const slope = flat[at] * dx + flat[at + 1] * dy + flat[at + 2] * dz;
                const room = flat[at + 3] - (flat[at] * px + flat[at + 1] * py + flat[at + 2] * pz);
                if (slope > 0) {
                    const t = room / slope;
                    if (t < last) {
                        last = t;
                        lastPlane = i;
                    }
                } else if (!inside) {
                    const t = slope < 0 ? room / slope : room < 0 ? Infinity : -Infinity;
                    if (t > first) {
                        first = t;
                        firstPlane = i;
                    }
                }
            }
            if (leave < last) [last, lastPlane] = [leave, -1];
            if (inside) {
                if (!Number.isFinite(last)) return null;
                return this.hit(origin, direction, last < -EDGE_TOLERANCE ? 0 : last, lastPlane);
            }
            if (enter > first) [first, firstPlane] = [enter, -1];
            const isMet = first < last && first >= -EDGE_TOLERANCE;
            return isMet ? this.hit(origin, direction, first, firstPlane) : null;
        }

        hit(origin, direction, distance, plane) {
            const point = along(origin, distance, direction);
            const isWall = plane < 0;
            return {
                point,
                distance,
                facet: isWall ? this.wallFacet : this.planeFacet[plane],
                normal: isWall ? unit([point[0], point[1], 0]) : this.planes[plane].slice(0, 3),
            };
        }
    }

    /** A closed mesh: one triangle after the other, in the order of their distance, until the point lies on it. */
    class Triangles {
        constructor({ planes, planeFacet, mesh }) {
            Object.assign(this, { planes, planeFacet });
            // Distance from each edge, positive on the triangle's side: functional . p - constant.
            this.edges = mesh.triangles.map((triangle, i) => {
                const corners = triangle.map((v) => mesh.vertices[v]);
                return corners.map((v, k) => {
                    const inward = unit(cross(planes[i], subtract(corners[(k + 1) % 3], v)));
                    return { functional: inward, constant: dot(inward, v) };
                });
            });
        }

        nearest(origin, direction, inside) {
            const ahead = [];
            this.planes.forEach((plane, i) => {
                const slope = dot(plane, direction);
                if (inside ? !(slope > 0) : !(slope < 0)) return;
                const distance = (plane[3] - dot(plane, origin)) / slope;
                if (distance >= -EDGE_TOLERANCE) ahead.push({ distance, i });
            });
            ahead.sort((a, b) => a.distance - b.distance || a.i - b.i);
            let beside = SLIP;
            let slipped = null; // by rounding, between two triangles: the one it passes closest by
            for (const { distance, i } of ahead) {
                const point = along(origin, distance, direction);
                const off = -Math.min(
                    ...this.edges[i].map(({ functional, constant }) => dot(functional, point) - constant),
                );
                const hit = { point, distance, facet: this.planeFacet[i], normal: this.planes[i].slice(0, 3) };
                if (off <= EDGE_TOLERANCE) return hit;
                if (off < beside) [beside, slipped] = [off, hit];
            }
            return inside ? slipped : null;
        }
    }

    const surfacesOf = (stone) => (stone.mesh ? new Triangles(stone) : new Planes(stone));

    // ---- Optics (optics/fresnel.py, reference/tracer.py) -----------------------------------------------

    /** Snell's law from air into the stone: tangential components divided by n (equation (2)). */
    function intoStone(d, normal, index) {
        const tangential = scaled(along(d, -dot(d, normal), normal), 1 / index);
        return along(tangential, -Math.sqrt(1 - dot(tangential, tangential)), normal);
    }

    /** Snell's law from the stone into air: tangential components times n (equation (4)). */
    function intoAir(d, normal, index) {
        const tangential = scaled(along(d, -dot(d, normal), normal), index);
        const cos = Math.sqrt(Math.max(1 - dot(tangential, tangential), 0));
        return { direction: along(tangential, cos, normal), cos };
    }

    /** Transmitted share of unpolarised light at an angle in air, by Gübelin's table or by Fresnel's equations. */
    function transmittance(cosAir, model, optics) {
        if (model.fresnel === 'gubelin') {
            const { gubelinAngles: angles, gubelinReflected: reflected } = optics;
            const angle = degrees(Math.max(cosAir, 0));
            let row = 0;
            while (row < angles.length - 2 && angles[row + 1] <= angle) row += 1;
            const slope = (reflected[row + 1] - reflected[row]) / (angles[row + 1] - angles[row]);
            return 1 - (reflected[row] + slope * (angle - angles[row]));
        }
        const n = model.index;
        const cosStone = Math.sqrt(1 - (1 - cosAir ** 2) / n ** 2);
        const s = (cosAir - n * cosStone) / (cosAir + n * cosStone);
        const p = (n * cosAir - cosStone) / (n * cosAir + cosStone);
        return 1 - 0.5 * (s ** 2 + p ** 2);
    }

    /** Section 2.3: what came in at z <= 0 is rear light; or through a pavilion facet, or from below. */
    function isRear({ rear: rule, ground }, { point, normal }, direction, level) {
        if (rule === 'facet') return normal[2] < -level;
        return rule === 'position' ? point[2] <= ground : direction[2] <= 0;
    }

    // ---- One ray (reference/tracer.py: sections 2.1 to 2.3 of the paper) -------------------------------

    /**
     * Follow the ray through a point of the view back into the stone, until it leaves: there its light came in.
     *
     * Returns {status, reflections, rear, intensity [%], points, facets, normals, directions, factors}: what it
     * met, in the order from the eye; `directions` has one more, from the eye; `factors` are T and S of both
     * crossings, `tOut` and `sOut` towards the eye, `tIn` and `sIn` into the stone.
     */
    function trace(surfaces, optics, view, model, x, y) {
        const [right, up, eye] = view.basis;
        const start = along(along(scaled(right, x), y, up), START_DISTANCE, eye);
        const direction = scaled(eye, -1);
        const isPrimary = model.intensity === 'primary';
        const path = {
            status: STATUS.MISSED,
            reflections: 0,
            rear: false,
            intensity: 0,
            points: [],
            facets: [],
            normals: [],
            directions: [direction],
            factors: null,
        };
        const meet = (hit, after) => {
            path.points.push(hit.point);
            path.facets.push(hit.facet);
            path.normals.push(hit.normal);
            path.directions.push(after);
        };

        let hit = surfaces.nearest(start, direction, false);
        if (!hit) return path;
        const cosEye = -dot(direction, hit.normal);
        let o = hit.point;
        let d = intoStone(direction, hit.normal, model.index);
        meet(hit, d);
        const tOut = transmittance(cosEye, model, optics);
        const sOut = isPrimary ? -dot(d, hit.normal) / cosEye : 1;

        for (let n = 0; n <= model.maxReflections; n++) {
            hit = surfaces.nearest(o, d, true);
            if (!hit) {
                path.status = STATUS.LOST;
                return path;
            }
            o = hit.point;
            const cos = dot(d, hit.normal);
            // Equation (3). At the critical angle itself the surface still reflects all light.
            if (model.index ** 2 * (1 - cos ** 2) < optics.leastTotal) {
                const out = intoAir(d, hit.normal, model.index);
                meet(hit, out.direction);
                const tIn = transmittance(out.cos, model, optics);
                const sIn = isPrimary ? out.cos / cos : 1;
                path.status = STATUS.EXITED;
                path.factors = { tIn, sIn, tOut, sOut };
                path.rear = isRear(model, hit, out.direction, optics.level);
                path.intensity = path.rear ? 0 : LIGHT_LEVEL * tIn * sIn * tOut * sOut;
                return path;
            }
            // Equation (5): total reflection turns the normal component round.
            d = along(d, -2 * cos, hit.normal);
            meet(hit, d);
            path.reflections += 1;
        }
        path.status = STATUS.TRAPPED;
        path.reflections = model.maxReflections; // the last one is no more allowed
        return path;
    }

    /** Angles to the normal at a path's point, on the way from the eye: of the ray before it, and after it [deg]. */
    function anglesAt(path, i) {
        const angle = (direction) => degrees(Math.abs(dot(direction, path.normals[i])));
        return [angle(path.directions[i]), angle(path.directions[i + 1])];
    }

    return Object.freeze({ STATUS, surfacesOf, trace, anglesAt, dot, unit, cross });
})();

if (typeof module !== 'undefined') module.exports = GemTracer;
