// The map: virtual facets as the polygons that they are, crisp at any zoom, and over them lines, the chosen point and
// its ray. Of a symmetric stone a part comes, with the images that make the whole of it.

import { Light, Tracer, hear, inNextFrame, number, tip } from './shared.js';
import { MODES } from './modes.js';

/** The map's margin around the stone, as a share of its width. */
const MARGIN = 0.03;
const ZOOMS = [0.7, 400];
/** A press that moves less than this is a click [CSS px]. */
const SLACK = 4;
/** Turn of the stone by a pixel of dragging [deg], and its largest tilt. */
const TURN = 0.18;
const MOST_TILT = 60;
/** Up to so many polygons have hairlines of their own colour, which close the seams between them. */
const MOST_LINED = 12000;
const STEPS = [0.005, 0.05];

const radians = (degrees) => (degrees * Math.PI) / 180;

export class FacetMap {
    /** `tilted` is called with tilt, azimuth and whether the hand has come to rest. */
    constructor(root, { tilted, drawn }) {
        Object.assign(this, { root, tilted, drawn });
        this.redraw = inNextFrame(() => this.frame && this.draw());
        this.base = root.querySelector('.facets');
        this.over = root.querySelector('.over');
        this.frame = null;
        this.mode = MODES.intensity;
        this.settings = { head: 10 };
        this.lit = null;
        this.withLines = false;
        this.path = null;
        this.point = null;
        this.zoom = 1;
        this.middle = { x: 0, y: 0 };
        this.paths = null;
        this.listen();
        new ResizeObserver(() => this.redraw()).observe(root);
    }

    /** Show a frame: at once, not with the screen's next one, as the hand waits for it. */
    setFrame(frame) {
        this.frame = frame;
        this.paths = null;
        this.draw();
    }

    setMode(name, settings) {
        this.mode = MODES[name];
        this.settings = settings;
        this.lit = null;
        this.paths = null;
        this.redraw();
    }

    /** Bring out one class of the mode; null for all. */
    light(which) {
        if (which === this.lit) return;
        this.lit = which;
        this.redraw();
    }

    // ---- Shapes ----

    /** The polygons of each class as one path, in the view's own lengths; and what of the view each class is. */
    build() {
        const { corners, ends, area } = this.frame.arrays;
        const { arrays } = this.frame;
        const paths = this.mode.classes.map(() => null);
        const shares = this.mode.classes.map(() => 0);
        this.classes = new Uint8Array(ends.length);
        let k = 0;
        let whole = 0;
        for (let i = 0; i < ends.length; i++) {
            const which = this.mode.classOf(arrays, i, this.settings);
            this.classes[i] = which;
            shares[which] += area[i];
            whole += area[i];
            const path = (paths[which] ??= new Path2D());
            path.moveTo(corners[2 * k], corners[2 * k + 1]);
            for (k++; k < ends[i]; k++) path.lineTo(corners[2 * k], corners[2 * k + 1]);
            path.closePath();
        }
        this.paths = paths;
        this.shares = shares.map((share) => (100 * share) / whole);
    }

    /** The view's scale on the canvas, and functions there and back, for a canvas of this width [CSS px]. */
    scale(width) {
        const pixels = (((1 - 2 * MARGIN) * width) / (2 * this.frame.halfWidth)) * this.zoom;
        const { x: mx, y: my } = this.middle;
        return {
            pixels,
            toCanvas: (x, y) => [width / 2 + pixels * (x - mx), width / 2 - pixels * (y - my)],
            toView: (u, v) => ({ x: (u - width / 2) / pixels + mx, y: (width / 2 - v) / pixels + my }),
        };
    }

    /** The colour of a class; faint where another one is brought out. */
    colourOf(which) {
        const { colour } = this.mode.classes[which];
        return this.lit === null || this.lit === which ? colour : `color-mix(in srgb, ${colour} 16%, ${this.ground})`;
    }

    draw() {
        if (!this.paths) this.build();
        this.ground = getComputedStyle(document.body).getPropertyValue('--map').trim() || '#ffffff';
        const { context, width, ratio } = fitted(this.base);
        const { pixels } = this.scale(width);
        context.setTransform(1, 0, 0, 1, 0, 0);
        context.clearRect(0, 0, this.base.width, this.base.height);
        const s = pixels * ratio;
        const u0 = (width / 2) * ratio - s * this.middle.x;
        const v0 = (width / 2) * ratio + s * this.middle.y;
        const isLined = this.frame.arrays.ends.length <= MOST_LINED;
        const paint = (how) => {
            for (const [a, b, c, d, e, f] of this.frame.images) {
                context.setTransform(s * a, -s * b, s * c, -s * d, u0 + s * e, v0 - s * f);
                this.paths.forEach((path, which) => path && how(path, this.colourOf(which)));
            }
        };
        // Hairlines first, and over them the polygons: what is left of the lines fills the seams, no more.
        context.lineWidth = 1.2 / s;
        context.lineJoin = 'round';
        if (isLined)
            paint((path, colour) => {
                context.strokeStyle = colour;
                context.stroke(path);
            });
        paint((path, colour) => {
            context.fillStyle = colour;
            context.fill(path);
        });
        this.drawOver();
        this.drawn(this.frame);
    }

    drawOver() {
        const { context, width, ratio } = fitted(this.over);
        context.setTransform(ratio, 0, 0, ratio, 0, 0);
        context.clearRect(0, 0, width, width);
        const { toCanvas } = this.scale(width);
        const { basis: [right, up, eye] } = this.frame.view;
        const onCanvas = (p) => toCanvas(Tracer.dot(p, right), Tracer.dot(p, up));
        if (this.withLines && this.geometry) {
            const seen = this.geometry.outlines.filter(({ normals }) =>
                normals.some((normal) => Tracer.dot(normal, eye) > 0),
            );
            Light.beginLines(context, seen.map(({ from, to }) => [onCanvas(from), onCanvas(to)]));
            context.lineWidth = 1.1;
            context.strokeStyle = 'rgb(255 255 255 / 0.8)';
            context.stroke();
        }
        if (this.path && this.path.status !== Tracer.STATUS.MISSED) {
            const lines = Light.lightLines(this.path).map((ends) => ends.map(onCanvas));
            for (const [colour, wider] of [['rgb(0 0 0 / 0.65)', 2.4], [Light.rayColour(this.path), 0]]) {
                Light.beginLines(context, lines.slice(0, -1));
                context.lineWidth = 1.6 + wider;
                context.lineCap = 'round';
                context.strokeStyle = colour;
                context.stroke();
            }
        }
        if (this.point) {
            const [u, v] = toCanvas(this.point.x, this.point.y);
            for (const [radius, colour, line] of [[7, '#000000', 3.5], [7, '#ffffff', 1.6]]) {
                context.beginPath();
                context.arc(u, v, radius, 0, 2 * Math.PI);
                context.lineWidth = line;
                context.strokeStyle = colour;
                context.stroke();
            }
        }
    }

    // ---- The polygon at a place ----

    /** Number of the polygon at a point of the view; -1 for none. */
    facetAt({ x, y }) {
        const { corners, ends } = this.frame.arrays;
        for (const [a, b, c, d, e, f] of this.frame.images) {
            // Images are turns and mirrors: their inverse is the transpose.
            const [px, py] = [a * (x - e) + b * (y - f), c * (x - e) + d * (y - f)];
            for (let i = 0, k = 0; i < ends.length; i++) {
                const first = k;
                k = ends[i];
                let isWithin = true;
                for (let j = first; j < k && isWithin; j++) {
                    const next = j + 1 < k ? j + 1 : first;
                    const [ax, ay, bx, by] = [corners[2 * j], corners[2 * j + 1], corners[2 * next], corners[2 * next + 1]];
                    isWithin = (bx - ax) * (py - ay) - (by - ay) * (px - ax) >= -1e-7;
                }
                if (isWithin) return i;
            }
        }
        return -1;
    }

    words(i) {
        const { arrays, images } = this.frame;
        if (i < 0) return '';
        if (arrays.status[i] === 2) return 'Near the girdle: light parts there, and single rays tell the score';
        const whole = arrays.area.reduce((a, b) => a + b, 0) * images.length;
        const light = arrays.status[i] === 1 ? 'trapped' : arrays.rear[i] ? 'rear light' : `${number(arrays.intensity[i], 1)} %`;
        const times = arrays.reflections[i];
        return `${light} · ${times} reflection${times === 1 ? '' : 's'} · ${Number(((100 * arrays.area[i]) / whole).toPrecision(2))} % of the view`;
    }

    // ---- The hand ----

    zoomBy(factor, at = null) {
        const width = this.over.clientWidth;
        const before = at && this.scale(width).toView(...at);
        this.zoom = Math.min(Math.max(this.zoom * factor, ZOOMS[0]), ZOOMS[1]);
        if (before) {
            const after = this.scale(width).toView(...at);
            this.middle = { x: this.middle.x + before.x - after.x, y: this.middle.y + before.y - after.y };
        }
        if (this.zoom <= 1) this.middle = { x: 0, y: 0 };
        this.redraw();
    }

    whole() {
        this.zoom = 1;
        this.middle = { x: 0, y: 0 };
        this.redraw();
    }

    turnBy(du, dv, isAtRest) {
        const { tilt, azimuth } = this.frame.view;
        const from = this.held ?? { x: tilt * Math.cos(radians(azimuth)), y: tilt * Math.sin(radians(azimuth)) };
        // The stone follows the hand, so the eye goes the other way.
        const to = { x: from.x - TURN * du, y: from.y + TURN * dv };
        const length = Math.hypot(to.x, to.y);
        if (length > MOST_TILT) for (const axis of ['x', 'y']) to[axis] *= MOST_TILT / length;
        this.held = to;
        const angle = Math.hypot(to.x, to.y);
        this.tilted(angle < 0.4 ? 0 : angle, (Math.atan2(to.y, to.x) * 180) / Math.PI, isAtRest);
    }

    pan(du, dv) {
        const { pixels } = this.scale(this.over.clientWidth);
        this.middle = { x: this.middle.x - du / pixels, y: this.middle.y + dv / pixels };
        this.redraw();
    }

    place(event) {
        const box = this.over.getBoundingClientRect();
        return [event.clientX - box.left, event.clientY - box.top];
    }

    listen() {
        const pointers = new Map();
        let travelled = 0;
        let span = 0;
        const spread = () => {
            const [a, b] = [...pointers.values()];
            return Math.hypot(a[0] - b[0], a[1] - b[1]);
        };
        const { over } = this;
        over.addEventListener('pointerdown', (event) => {
            over.setPointerCapture(event.pointerId);
            pointers.set(event.pointerId, this.place(event));
            if (pointers.size === 1) travelled = 0;
            if (pointers.size === 2) span = spread();
            this.held = null;
            tip.hide();
        });
        over.addEventListener('pointermove', (event) => {
            if (!this.frame) return;
            const before = pointers.get(event.pointerId);
            const now = this.place(event);
            if (!before) {
                if (event.pointerType !== 'touch') this.hover(event, now);
                return;
            }
            const [du, dv] = [now[0] - before[0], now[1] - before[1]];
            pointers.set(event.pointerId, now);
            travelled += Math.hypot(du, dv);
            if (pointers.size === 2) {
                const wide = spread();
                this.pan(du / 2, dv / 2);
                if (span > 0) this.zoomBy(wide / span, now);
                span = wide;
            } else if (travelled > SLACK) {
                over.classList.add('turning');
                if (event.shiftKey || event.buttons === 4) this.pan(du, dv);
                else this.turnBy(du, dv, false);
            }
        });
        const release = (event) => {
            const wasDown = pointers.delete(event.pointerId);
            if (pointers.size === 0) over.classList.remove('turning');
            else travelled = Infinity; // one of two fingers left: no click
            if (this.held && pointers.size === 0) {
                this.turnBy(0, 0, true);
                this.held = null;
            }
            if (!wasDown || event.type !== 'pointerup' || travelled > SLACK || !this.frame) return;
            hear.choose(this.scale(over.clientWidth).toView(...this.place(event)));
        };
        over.addEventListener('pointerup', release);
        over.addEventListener('pointercancel', release);
        over.addEventListener('pointerleave', () => tip.hide());
        over.addEventListener('dblclick', () => this.whole());
        over.addEventListener('wheel', (event) => {
            event.preventDefault();
            this.zoomBy(Math.exp(-0.0018 * event.deltaY), this.place(event));
        }, { passive: false });
        over.addEventListener('keydown', (event) => this.press(event));
    }

    hover(event, [u, v]) {
        const text = this.words(this.facetAt(this.scale(this.over.clientWidth).toView(u, v)));
        if (text) tip.show(event, text);
        else tip.hide();
    }

    press(event) {
        if (!this.frame || event.ctrlKey || event.metaKey || event.altKey) return;
        const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
        const actions = { '+': () => this.zoomBy(1.25), '=': () => this.zoomBy(1.25), '-': () => this.zoomBy(0.8), 0: () => this.whole(), Home: () => this.whole() };
        if (moves[event.key]) {
            const step = (STEPS[event.shiftKey ? 1 : 0] * this.frame.halfWidth) / Math.min(this.zoom, 20);
            const from = this.point ?? { x: 0, y: 0 };
            const [dx, dy] = moves[event.key];
            hear.choose({ x: from.x + dx * step, y: from.y + dy * step });
        } else if (actions[event.key]) actions[event.key]();
        else return;
        event.preventDefault();
    }
}

/**
 * Fit a canvas to its place, at the screen's own pixels. Drawn by the processor: that is as fast for polygons as most
 * graphics cards are, and far faster than a browser that only plays one.
 */
function fitted(canvas) {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const pixels = Math.max(Math.round(width * ratio), 1);
    if (canvas.width !== pixels) canvas.width = canvas.height = pixels;
    return { context: canvas.getContext('2d', { willReadFrequently: true }), width, ratio: pixels / width };
}
