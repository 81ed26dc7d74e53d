// The profile across the width, with what laboratories write at it, and handles to drag: the table's corner takes table
// size and crown angle along, the culet the pavilion angle. By keys the sliders do the same.

import { Tracer, drawing, find, number } from './shared.js';

const [CROWN, PAVILION, TABLE] = ['crown_angle', 'pavilion_angle', 'table'];
/** Room beside the stone, and above and below it [share of the width]. */
const ROOM = { x: 0.1, y: 0.14 };
const HANDLE = 7;

const degrees = (radians) => (radians * 180) / Math.PI;
const tan = (angle) => Math.tan((angle * Math.PI) / 180);

export class Profile {
    /** `moved` is called with changed values, and words once the hand has come to rest. */
    constructor(root, moved) {
        Object.assign(this, { root, moved });
        this.svg = find(root, 'svg');
        this.listen();
        new ResizeObserver(() => this.draw()).observe(root);
    }

    /** Show a stone: its mesh and edges, and the values of its sliders. */
    show(mesh, geometry, values) {
        const xs = mesh.vertices.map(([x]) => x);
        const zs = mesh.vertices.map(([, , z]) => z);
        Object.assign(this, {
            geometry, values, points: mesh.vertices.map(([x, , z]) => [x, z]),
            half: Math.max(...xs.map(Math.abs)), top: Math.max(...zs), bottom: Math.min(...zs),
        });
        this.draw();
    }

    get hasTable() {
        return [TABLE, CROWN].every((key) => typeof this.values[key] === 'number');
    }

    draw() {
        if (!this.geometry || this.root.hidden) return;
        const { half, top, bottom, values } = this;
        const width = Math.max(this.svg.parentElement.clientWidth - 28, 160);
        this.scale = width / (2 * half * (1 + 2 * ROOM.x));
        const room = 2 * half * ROOM.y;
        const height = this.scale * (top - bottom + 2 * room);
        const at = (x, z) => [width / 2 + this.scale * x, this.scale * (top + room - z)];
        const line = (from, to, kind) => {
            const [[x1, y1], [x2, y2]] = [at(...from), at(...to)];
            return drawing('line', { class: kind, x1, y1, x2, y2 });
        };
        const words = (x, z, text, anchor) => {
            const [u, v] = at(x, z);
            return drawing('text', { x: u, y: v, 'text-anchor': anchor }, text);
        };
        const edges = this.geometry.outlines
            .filter(({ normals }) => normals.some((normal) => normal[1] < -1e-9))
            .map(({ from, to }) => line([from[0], from[2]], [to[0], to[2]], 'edge'));
        const hull = hullOf(this.points).map(([x, z]) => at(x, z).map((v) => v.toFixed(1)).join(',')).join(' ');
        const drawn = [...edges, drawing('polygon', { class: 'hull', points: hull })];
        if (this.hasTable) {
            const corner = (half * values[TABLE]) / 100;
            drawn.push(
                words(0, top + 0.035 * half, `${number(values[TABLE], 1)} %`, 'middle'),
                words(0.5 * (half + corner) + 0.04 * half, top, `${number(values[CROWN], 1)}°`, 'start'),
                this.handle('table', at(corner, top)),
            );
        }
        if (typeof values[PAVILION] === 'number')
            drawn.push(
                words(0.62 * half, 0.55 * bottom, `${number(values[PAVILION], 1)}°`, 'start'),
                this.handle('culet', at(0, bottom)),
            );
        Object.entries({ viewBox: `0 0 ${width} ${height}`, width, height }).forEach(([key, value]) => this.svg.setAttribute(key, value));
        this.svg.replaceChildren(...drawn);
    }

    handle(which, [cx, cy]) {
        const made = drawing('circle', { class: `handle ${which}`, cx, cy, r: HANDLE });
        made.dataset.handle = which;
        return made;
    }

    listen() {
        let held = null;
        this.svg.addEventListener('pointerdown', (event) => {
            const which = event.target.dataset.handle;
            if (!which) return;
            event.preventDefault();
            this.svg.setPointerCapture(event.pointerId);
            held = { which, x: event.clientX, y: event.clientY, values: { ...this.values }, scale: this.scale };
        });
        this.svg.addEventListener('pointermove', (event) => {
            if (held) this.take(held, event, false);
        });
        const release = (event) => {
            if (held) this.take(held, event, true);
            held = null;
        };
        this.svg.addEventListener('pointerup', release);
        this.svg.addEventListener('pointercancel', release);
    }

    /** Where the hand has taken a handle, as values: the point of the stone stays under it. */
    take({ which, x, y, values, scale }, event, isAtRest) {
        const right = (event.clientX - x) / scale;
        const up = (y - event.clientY) / scale;
        const { half } = this;
        const round = (value) => Number(value.toFixed(2));
        if (which === 'table') {
            const before = (half * values[TABLE]) / 100;
            const corner = Math.min(Math.max(before + right, 0.05 * half), 0.95 * half);
            const height = Math.max((half - before) * tan(values[CROWN]) + up, 0.005 * half);
            const changed = { [TABLE]: round((100 * corner) / half), [CROWN]: round(degrees(Math.atan2(height, half - corner))) };
            this.moved(changed, isAtRest ? `Table ${number(changed[TABLE], 1)} %, crown ${number(changed[CROWN], 1)}°` : null);
            return;
        }
        const run = half * (1 - (values.culet ?? 0) / 100);
        const depth = Math.max(run * tan(values[PAVILION]) - up, 0.01 * half);
        const angle = round(degrees(Math.atan2(depth, run)));
        this.moved({ [PAVILION]: angle }, isAtRest ? `Pavilion angle ${number(angle, 1)}°` : null);
    }
}

/** The convex hull of points, by Andrew's monotone chain (1979). */
function hullOf(points) {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const isRight = (a, b, c) => Tracer.cross([b[0] - a[0], b[1] - a[1], 0], [c[0] - a[0], c[1] - a[1], 0])[2] <= 1e-12;
    const chain = (all) => {
        const out = [];
        for (const point of all) {
            while (out.length > 1 && isRight(out.at(-2), out.at(-1), point)) out.pop();
            out.push(point);
        }
        return out.slice(0, -1);
    };
    return [...chain(sorted), ...chain(sorted.reverse())];
}
