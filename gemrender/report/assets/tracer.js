'use strict';

// The paper's tracer in float64: gemrender/reference/surfaces.py and tracer.py, one ray at a time and with the
// same rules, so that the path shown is the path that was scored. Lengths in girdle radii, angles in degrees.
//
// A stone comes as the report embeds it:
//
//     vertices          57 [x, y, z]
//     triangleNormals   78 outward unit normals
//     triangleOffsets   78 plane offsets: a point p of the triangle has normal . p = offset
//     round             whether the girdle's wall is the cylinder of radius 1
//     halfSpaces        whether the solid is what lies inside all planes and that cylinder (tilted facets)
//     model             {index, fresnel, rear, intensity, maxReflections}
//
// and the topology, the same for every stone:
//
//     triangles, triangleFacet            78 [vertex, vertex, vertex], and the facet of each
//     girdle                              number of the girdle among the facets
//     girdleUpper, girdleLower            16 vertices of each edge
//     upperTriangles, lowerTriangles      16 triangles that go on beyond their chord
//     gubelinAngles, gubelinReflected     Gübelin's table [deg, share]
//     leastTotal                          n^2 sin^2(theta) from which on all light is reflected

const GemTracer = (() => {
    /** Slack of the tests of edges and distances: some thousand roundings of float64. */
    const EDGE_TOLERANCE = 1e-11;
    /** A measured wall is searched for in so many steps between two cylinders, then by halving to rounding. */
    const WALL_STEPS = 16;
    const WALL_HALVINGS = 46;
    /** Least height that a measured wall is interpolated over. */
    const KNIFE_EDGE = 1e-9;
    /** Where rays begin, outside every stone. */
    const START_DISTANCE = 10;
    const LIGHT_LEVEL = 100;
    const TURN = 2 * Math.PI;

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
    /** Remainder that is never negative, as Python's. */
    const modulo = (x, m) => ((x % m) + m) % m;
    const degrees = (cos) => (Math.acos(Math.min(Math.max(cos, -1), 1)) * 180) / Math.PI;

    // ---- The girdle's wall (stone/girdle.py) -----------------------------------------------------------

    class Girdle {
        constructor(upper, lower, isRound) {
            this.isRound = isRound;
            this.upper = upper;
            this.lower = lower;
            this.upperRing = ring(upper);
            this.lowerRing = ring(lower);
            const radii = [...upper, ...lower].map((v) => Math.hypot(v[0], v[1]));
            const largest = Math.max(...radii);
            const smallest = Math.min(...radii);
            this.largestRadius = largest;
            this.smallestRadius = smallest - (largest - smallest); // less what scallops may add
            this.heights = [Math.min(...lower.map((v) => v[2])), Math.max(...upper.map((v) => v[2]))];
        }

        /** The wall's radius at the azimuth of a point and at its height. */
        radius(p) {
            return this.isRound ? 1 : this.wall(Math.atan2(p[1], p[0]), p[2]).radius;
        }

        /** The wall's outward unit normal at a point of it. */
        normal(p) {
            const r = Math.hypot(p[0], p[1]);
            const radial = [p[0] / r, p[1] / r, 0];
            if (this.isRound) return radial;
            const { radius, byAzimuth, byHeight } = this.wall(Math.atan2(p[1], p[0]), p[2]);
            // The gradient of r - rho(azimuth, z).
            const turn = byAzimuth / radius;
            return unit([radial[0] + turn * radial[1], radial[1] - turn * radial[0], -byHeight]);
        }

        /** Radius of a measured wall, and its derivatives by azimuth and height. */
        wall(azimuth, z) {
            const top = around(this.upperRing, azimuth);
            const bottom = around(this.lowerRing, azimuth);
            const thickness = Math.max(top.height - bottom.height, KNIFE_EDGE);
            const share = Math.min(Math.max((z - bottom.height) / thickness, -1), 2);
            const byShare = top.radius - bottom.radius;
            const shareByAzimuth =
                -(bottom.heightSlope + share * (top.heightSlope - bottom.heightSlope)) / thickness;
            return {
                radius: (1 - share) * bottom.radius + share * top.radius,
                byAzimuth:
                    (1 - share) * bottom.radiusSlope + share * top.radiusSlope + byShare * shareByAzimuth,
                byHeight: byShare / thickness,
            };
        }
    }

    /** A ring of vertices by azimuth, with the slopes of radius and height between neighbours. */
    function ring(vertices) {
        const sorted = vertices
            .map((v) => ({ angle: Math.atan2(v[1], v[0]), radius: Math.hypot(v[0], v[1]), height: v[2] }))
            .sort((a, b) => a.angle - b.angle);
        return sorted.map((at, i) => {
            const next = sorted[(i + 1) % sorted.length];
            const step = next.angle - at.angle + (i + 1 === sorted.length ? TURN : 0);
            return {
                ...at,
                radiusSlope: (next.radius - at.radius) / step,
                heightSlope: (next.height - at.height) / step,
            };
        });
    }

    /** Radius and height of a ring at an azimuth, linear between its vertices, and their derivatives. */
    function around(sortedRing, azimuth) {
        let sector = sortedRing.length - 1; // before the first: the last, from the other side of pi
        while (sector > 0 && sortedRing[sector].angle > azimuth) sector -= 1;
        if (sortedRing[sector].angle > azimuth) sector = sortedRing.length - 1;
        const at = sortedRing[sector];
        const beyond = modulo(azimuth - at.angle, TURN);
        return {
            radius: at.radius + at.radiusSlope * beyond,
            height: at.height + at.heightSlope * beyond,
            radiusSlope: at.radiusSlope,
            heightSlope: at.heightSlope,
        };
    }

    /** Distances at which a ray enters and leaves a vertical cylinder; infinite where it misses it. */
    function cylinder(origin, direction, radius) {
        const a = direction[0] ** 2 + direction[1] ** 2;
        const b = origin[0] * direction[0] + origin[1] * direction[1];
        const c = origin[0] ** 2 + origin[1] ** 2 - radius ** 2;
        if (a === 0) return c <= 0 ? [-Infinity, Infinity] : [Infinity, -Infinity];
        const root = b * b - a * c;
        if (!(root >= 0)) return [Infinity, -Infinity];
        return [(-b - Math.sqrt(root)) / a, (-b + Math.sqrt(root)) / a];
    }

    // ---- The 79 surfaces (reference/surfaces.py) -------------------------------------------------------

    class Surfaces {
        constructor(stone, topology) {
            this.topology = topology;
            this.normals = stone.triangleNormals;
            this.offsets = stone.triangleOffsets;
            this.count = this.normals.length;
            this.isHalfSpaces = stone.halfSpaces;
            const pick = (numbers) => numbers.map((i) => stone.vertices[i]);
            this.girdle = new Girdle(pick(topology.girdleUpper), pick(topology.girdleLower), stone.round);

            // Distance from each edge, positive on the triangle's side: functional . p - constant.
            this.edges = topology.triangles.map((triangle, i) => {
                const corners = pick(triangle);
                return corners.map((v, k) => {
                    const inward = unit(cross(this.normals[i], subtract(corners[(k + 1) % 3], v)));
                    return { functional: inward, constant: dot(inward, v) };
                });
            });
            // Of a triangle that goes on beyond its chord, the one across the girdle.
            this.opposite = new Array(this.count).fill(-1);
            topology.upperTriangles.forEach((upper, j) => {
                this.opposite[upper] = topology.lowerTriangles[j];
                this.opposite[topology.lowerTriangles[j]] = upper;
            });
        }

        /**
         * The nearest surface that a ray goes out through, or comes in through; null if it meets none.
         * Surfaces that face the other way are passed by, so the surface just left needs no offset.
         */
        nearest(origin, direction, inside) {
            const distances = new Float64Array(this.count + 1).fill(Infinity);
            for (let i = 0; i < this.count; i++) {
                const slope = dot(this.normals[i], direction);
                if (inside ? !(slope > 0) : !(slope < 0)) continue;
                const t = (this.offsets[i] - dot(this.normals[i], origin)) / slope;
                if (t >= -EDGE_TOLERANCE) distances[i] = t;
            }
            distances[this.count] = this.girdleDistance(origin, direction, inside);

            // One surface after the other, in the order of their distance, until the point lies on it.
            let slipped = null; // by rounding, between two surfaces: the nearest plane ahead
            for (;;) {
                let surface = 0;
                for (let i = 1; i <= this.count; i++) if (distances[i] < distances[surface]) surface = i;
                const distance = distances[surface];
                if (!Number.isFinite(distance)) return inside ? slipped : null;
                const point = along(origin, distance, direction);
                const onGirdle = surface === this.count;
                const hit = () => ({
                    point,
                    distance,
                    facet: onGirdle ? this.topology.girdle : this.topology.triangleFacet[surface],
                    normal: onGirdle ? this.girdle.normal(point) : this.normals[surface],
                });
                if (onGirdle || this.within(surface, point)) return hit();
                slipped ??= hit();
                distances[surface] = Infinity;
            }
        }

        /** Whether a point of a triangle's plane lies on the triangle, or beyond its chord. */
        within(triangle, point) {
            if (this.isHalfSpaces) return this.insideAll(point);
            const [first, chord, last] = this.edges[triangle].map(
                ({ functional, constant }) => dot(functional, point) - constant,
            );
            if (Math.min(first, chord, last) >= -EDGE_TOLERANCE) return true;
            const opposite = this.opposite[triangle];
            if (opposite < 0 || chord > 0) return false;
            // The same plane, until it meets the wall or the facet on the girdle's other side.
            return (
                Math.hypot(point[0], point[1]) <= this.girdle.radius(point) + EDGE_TOLERANCE &&
                dot(this.normals[opposite], point) <= this.offsets[opposite] + EDGE_TOLERANCE
            );
        }

        /** Whether a point lies in all half-spaces of a stone with tilted facets, and in the cylinder. */
        insideAll(point) {
            return (
                Math.hypot(point[0], point[1]) <= 1 + EDGE_TOLERANCE &&
                this.normals.every((normal, i) => dot(normal, point) <= this.offsets[i] + EDGE_TOLERANCE)
            );
        }

        /** Distance to the girdle's wall; infinite for a ray that misses it. */
        girdleDistance(origin, direction, inside) {
            const t = this.girdle.isRound
                ? cylinder(origin, direction, 1)[inside ? 1 : 0]
                : this.measuredWall(origin, direction, inside);
            if (!Number.isFinite(t) || t < -EDGE_TOLERANCE) return Infinity;
            const point = along(origin, t, direction);
            if (!this.girdle.isRound) {
                const facing = dot(direction, this.girdle.normal(point));
                if (inside ? !(facing > 0) : !(facing < 0)) return Infinity;
            }
            return inside || this.onGirdle(point) ? t : Infinity;
        }

        /** First distance at which a ray crosses the measured wall outwards, or inwards; else infinite. */
        measuredWall(origin, direction, inside) {
            const { girdle } = this;
            // The wall lies between two cylinders and between two heights.
            const [near, far] = cylinder(origin, direction, girdle.largestRadius);
            const [nearInner, farInner] = cylinder(origin, direction, girdle.smallestRadius);
            const levels = girdle.heights
                .map((z) => (z - origin[2]) / direction[2])
                .filter((t) => !Number.isNaN(t)) // within that level
                .sort((a, b) => a - b);
            let first = Math.max(near, 0);
            let last = far;
            if (levels.length) first = Math.max(first, levels[0]);
            if (levels.length === 2) last = Math.min(last, levels[1]);
            if (inside && Number.isFinite(farInner)) first = Math.max(first, farInner);
            if (!inside && Number.isFinite(nearInner) && nearInner > first) last = Math.min(last, nearInner);
            if (!(last > first)) return Infinity;

            const crossed = (t) => {
                const p = along(origin, t, direction);
                return Math.hypot(p[0], p[1]) > girdle.radius(p) === inside;
            };
            // The start counts as not crossed: it is the surface just left, or the cylinder's outside.
            let low = first;
            for (let k = 1; k <= WALL_STEPS; k++) {
                let high = first + (last - first) * (k / WALL_STEPS);
                if (!crossed(high)) {
                    low = high;
                    continue;
                }
                for (let n = 0; n < WALL_HALVINGS; n++) {
                    const middle = 0.5 * (low + high);
                    if (crossed(middle)) high = middle;
                    else low = middle;
                }
                return 0.5 * (low + high);
            }
            return Infinity;
        }

        /** Whether a point of the wall lies between the facets above and below the girdle. */
        onGirdle(point) {
            if (this.isHalfSpaces) return this.insideAll(point);
            const below = (triangles, vertices) => {
                // Of each ring only the facet of the point's own sector bounds it.
                const triangle = triangles[sectorOf(point, vertices)];
                return dot(this.normals[triangle], point) <= this.offsets[triangle];
            };
            return (
                below(this.topology.upperTriangles, this.girdle.upper) &&
                below(this.topology.lowerTriangles, this.girdle.lower)
            );
        }
    }

    /** The sector of a ring of vertices, in their own order, that a point lies in. */
    function sectorOf(point, vertices) {
        const start = Math.atan2(vertices[0][1], vertices[0][0]);
        const azimuth = modulo(Math.atan2(point[1], point[0]) - start, TURN);
        let sector = vertices.length - 1;
        while (sector > 0 && modulo(Math.atan2(vertices[sector][1], vertices[sector][0]) - start, TURN) > azimuth)
            sector -= 1;
        return sector;
    }

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
    function transmittance(cosAir, model, topology) {
        if (model.fresnel === 'gubelin') {
            const { gubelinAngles: angles, gubelinReflected: reflected } = topology;
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

    // ---- One ray (reference/tracer.py: sections 2.1 to 2.3 of the paper) -------------------------------

    /**
     * Follow the ray through a point of the view back into the stone, until it leaves: there its light came in.
     *
     * Returns {status, reflections, rear, intensity [%], points, facets, normals, directions, factors}: what it
     * met, in the order from the eye; `directions` has one more, from the eye; `factors` are T and S of both
     * crossings, `tOut` and `sOut` towards the eye, `tIn` and `sIn` into the stone.
     */
    function trace(surfaces, view, model, x, y) {
        const [right, up, eye] = view.basis;
        const start = along(along(scaled(right, x), y, up), START_DISTANCE, eye);
        return follow(surfaces, model, start, scaled(eye, -1));
    }

    function follow(surfaces, model, start, direction) {
        const { topology } = surfaces;
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
        const tOut = transmittance(cosEye, model, topology);
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
            if (model.index ** 2 * (1 - cos ** 2) < topology.leastTotal) {
                const out = intoAir(d, hit.normal, model.index);
                meet(hit, out.direction);
                const tIn = transmittance(out.cos, model, topology);
                const sIn = isPrimary ? out.cos / cos : 1;
                path.status = STATUS.EXITED;
                path.factors = { tIn, sIn, tOut, sOut };
                // Section 2.3: light that came in at z <= 0 is rear light, of intensity 0.
                path.rear = model.rear === 'position' ? o[2] <= 0 : out.direction[2] <= 0;
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

    return Object.freeze({ STATUS, Surfaces, trace, follow, anglesAt, dot, unit, cross });
})();

if (typeof module !== 'undefined') module.exports = GemTracer;
