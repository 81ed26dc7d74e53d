'use strict';

// How light is shown: the codes of a map's pixels and their colours, and the ray as lines on a canvas.

const GemLight = (() => {
    const { STATUS } = GemTracer;
    const { data } = GemPage;
    const { colours, codes } = data;

    /** Canvases are drawn at least at this many pixels a CSS pixel: for sharp paper too. */
    const LEAST_PIXEL_RATIO = 2;
    /** Most reflections that are numbered in the drawings. */
    const MOST_NUMBERED = 16;
    /** Length of the ray drawn outside the stone [stone's unit]. */
    const OUTSIDE_LENGTH = 0.55;
    const REAR_RAY = '#ffffff';

    /** What a map's code is: the number of its band, or that it has no intensity. */
    const [REAR, UNSOLVED, OUTSIDE] = [100, 101, -1];
    function kindOf(code) {
        if (code === codes.outside) return OUTSIDE;
        if (code === codes.rear) return REAR;
        if (code === codes.unsolved) return UNSOLVED;
        return data.stones[0].score.bands.findIndex((band) => code >= band.low * codes.steps);
    }

    const kindColour = (kind) =>
        kind === REAR ? colours.rear : kind === UNSOLVED ? colours.unsolved : colours.bands[kind];

    /** Of every code its kind, and its colour as a canvas holds it in memory. */
    const kinds = new Int8Array(1 << 16);
    const painted = new Uint32Array(1 << 16);
    for (let code = 0; code <= codes.outside; code++) {
        kinds[code] = kindOf(code);
        if (code === codes.outside) continue;
        const rgb = parseInt(kindColour(kinds[code]).slice(1), 16);
        painted[code] = (((rgb & 255) << 16) | (rgb & 0xff00) | (rgb >> 16) | 0xff000000) >>> 0;
    }

    /** The code of a ray's pixel, as the report writes it. */
    function codeOf(path) {
        if (path.status === STATUS.MISSED) return codes.outside;
        if (path.status !== STATUS.EXITED) return codes.unsolved;
        return path.rear ? codes.rear : Math.min(Math.floor(path.intensity * codes.steps), codes.rear - 1);
    }

    function pathColour(path) {
        return kindColour(kindOf(codeOf(path)));
    }

    /** The paper's shades of red by intensity, and white for rear light. */
    function rayColour(path) {
        if (path.status !== STATUS.EXITED) return colours.unsolved;
        if (path.rear) return REAR_RAY;
        const place = (Math.min(path.intensity, 100) / 100) * (colours.rays.length - 1);
        const shade = Math.min(Math.floor(place), colours.rays.length - 2);
        const mixed = [1, 3, 5].map((at) => {
            const [from, to] = [shade, shade + 1].map((i) => parseInt(colours.rays[i].slice(at, at + 2), 16));
            return Math.round(from + (place - shade) * (to - from));
        });
        return `rgb(${mixed.join(', ')})`;
    }

    /** Width of a ray's lines [CSS px]; those of a long path are many. */
    const rayWidth = (path) => (path.reflections > MOST_NUMBERED ? 1.1 : 2.5);

    /** The lines of a path with the light's own sense: [from, to] from where it comes in to the eye. */
    function lightLines(path) {
        const { points, directions } = path;
        const beyond = (p, d, length) => p.map((value, i) => value + length * d[i]);
        const stations = [beyond(points[0], directions[0], -OUTSIDE_LENGTH), ...points];
        if (path.status === STATUS.EXITED)
            stations.push(beyond(points.at(-1), directions.at(-1), OUTSIDE_LENGTH));
        stations.reverse();
        return stations.slice(1).map((to, i) => [stations[i], to]);
    }

    /** Labels of a path's points, in the order from the eye. */
    function stationNames(path) {
        const last = path.points.length - 1;
        const isOut = path.status === STATUS.EXITED;
        return path.points.map((_, i) => {
            if (i === 0) return 'eye';
            if (isOut && i === last) return 'in';
            return String(isOut ? last - i : i);
        });
    }

    /** The width of a canvas' place in the page [CSS px], and what it should have there [pixels]. */
    function placeOf(canvas) {
        const ratio = Math.max(window.devicePixelRatio || 1, LEAST_PIXEL_RATIO);
        const width = canvas.clientWidth || canvas.width / ratio;
        return { width, pixels: Math.max(Math.round(width * ratio), 1) };
    }

    /** Whether a canvas has been drawn for the place that it has in the page. */
    const isFitted = (canvas) => canvas.width === placeOf(canvas).pixels;

    /** Fit a canvas to its place in the page; returns its context, scaled to CSS pixels, and its width. */
    function fitted(canvas) {
        const { width, pixels } = placeOf(canvas);
        if (canvas.width !== pixels) canvas.width = canvas.height = pixels;
        const context = canvas.getContext('2d');
        context.setTransform(pixels / width, 0, 0, pixels / width, 0, 0);
        return { context, width, pixels };
    }

    /** Begin a path of lines [from, to] on a canvas. */
    function beginLines(context, lines) {
        context.beginPath();
        for (const [from, to] of lines) {
            context.moveTo(...from);
            context.lineTo(...to);
        }
    }

    /** Draw the lines of a ray, an arrow in the middle of each, and its numbered points. */
    function drawArrows(context, lines, colour, size) {
        context.fillStyle = colour;
        for (const [from, to] of lines) {
            const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
            if (length < 4.5 * size) continue;
            context.save();
            context.translate((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
            context.rotate(Math.atan2(to[1] - from[1], to[0] - from[0]));
            context.beginPath();
            context.moveTo(size, 0);
            context.lineTo(-size, 0.72 * size);
            context.lineTo(-0.55 * size, 0);
            context.lineTo(-size, -0.72 * size);
            context.closePath();
            context.fill();
            context.restore();
        }
    }

    return Object.freeze({
        REAR, UNSOLVED, OUTSIDE, MOST_NUMBERED, kindOf, kindColour, kinds, painted, codeOf, pathColour, rayColour,
        rayWidth, lightLines, stationNames, isFitted, fitted, beginLines, drawArrows,
    });
})();
