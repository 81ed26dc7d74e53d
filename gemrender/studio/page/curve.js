// The curve of Average and Rear over tilt, which fills in from straight above outwards.

import { drawing, find, inNextFrame, number } from './shared.js';

const HEIGHT = 190;
const EDGES = { left: 40, right: 12, top: 10, bottom: 24 };

export class Curve {
    constructor(root, chosen) {
        Object.assign(this, { root, chosen });
        this.redraw = inNextFrame(() => this.draw());
        this.svg = find(root, 'svg');
        this.points = new Map();
        this.baseline = null;
        this.to = 30;
        new ResizeObserver(() => this.draw()).observe(root);
        this.svg.addEventListener('click', (event) => {
            const angle = this.angleAt?.(event.clientX - this.svg.getBoundingClientRect().left);
            if (angle !== undefined) this.chosen(Math.round(Math.min(Math.max(angle, -this.to), this.to)));
        });
    }

    clear() {
        this.old = this.points.size > 8 ? this.points : this.old;
        this.points = new Map();
    }

    /** Keep the present curve as that of the baseline; null for none. */
    keep(isKept) {
        this.baseline = isKept ? new Map(this.points) : null;
        this.draw();
    }

    add({ turn, to, average, rear, bound }) {
        this.to = to;
        this.points.set(turn, { average, rear, bound });
        this.redraw();
    }

    draw() {
        const width = Math.max(this.root.clientWidth - 2, 200);
        const { left, right, top, bottom } = EDGES;
        const x = (angle) => left + ((angle + this.to) / (2 * this.to)) * (width - left - right);
        const y = (value) => HEIGHT - bottom - (value / 100) * (HEIGHT - top - bottom);
        this.angleAt = (u) => ((u - left) / (width - left - right)) * 2 * this.to - this.to;
        const drawn = [];
        for (const value of [0, 25, 50, 75, 100])
            drawn.push(
                drawing('line', { class: 'grid', x1: left, x2: width - right, y1: y(value), y2: y(value) }),
                drawing('text', { x: left - 6, y: y(value) + 4, 'text-anchor': 'end' }, String(value)),
            );
        for (let angle = -this.to; angle <= this.to; angle += 10)
            drawn.push(drawing('text', { x: x(angle), y: HEIGHT - 7, 'text-anchor': 'middle' }, `${number(angle, 0)}°`));
        const sets = [[this.baseline, 'before'], [this.points.size < 8 ? this.old : null, 'faded'], [this.points, 'now']];
        for (const [points, kind] of sets) {
            if (!points?.size) continue;
            const sorted = [...points].sort((a, b) => a[0] - b[0]);
            for (const key of ['average', 'rear']) {
                const line = sorted.map(([angle, of]) => `${x(angle).toFixed(1)},${y(of[key]).toFixed(1)}`).join(' ');
                drawn.push(drawing('polyline', { class: `${key} ${kind}`, fill: 'none', points: line }));
            }
        }
        Object.entries({ viewBox: `0 0 ${width} ${HEIGHT}`, width, height: HEIGHT }).forEach(([key, value]) => this.svg.setAttribute(key, value));
        this.svg.replaceChildren(...drawn);
        const at = this.points.get(0);
        const ends = [...this.points.keys()];
        find(this.root, '.note').textContent = at
            ? `The stone turned about the level axis x, by up to ${number(Math.max(...ends), 0)}°. A click tilts the map so far.`
            : 'Fills in while nothing moves.';
        const values = [...this.points.values()].map(({ average }) => average);
        if (values.length)
            this.svg.setAttribute('aria-label', `Average over tilt: from ${number(Math.min(...values), 1)} to ${number(Math.max(...values), 1)} per cent`);
    }
}
