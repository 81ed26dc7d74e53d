'use strict';

// The map of a stone: its pixels, the outlines over them, the ray through the chosen point, and the choice of it.

const GemMap = (() => {
    const { STATUS, dot } = GemTracer;
    const { number, find, tip } = GemDom;
    const { data, choose, lights } = GemPage;
    const { codes } = data;
    const { OUTSIDE, MOST_NUMBERED, kinds, rayColour, rayWidth, lightLines, fitted, beginLines, drawArrows } = GemLight;
    const { facetName } = GemRay;

    /** The map's margin around the stone, as a share of its width. */
    const MAP_MARGIN = 0.03;
    /** Pixels that the point moves by an arrow key, and with Shift. */
    const STEPS = [1, 16];
    /** How much is left of the map beside the band that is pointed at. */
    const FADED = 0.14;

    class MapView {
        constructor(root, card) {
            this.card = card;
            this.root = root;
            this.canvas = find(root, 'canvas');
            this.canvas.setAttribute(
                'aria-label',
                `Intensity map of ${card.stone.name}, seen from above. Arrow keys move the point whose ray is shown.`,
            );
            this.withLines = this.withVirtual = false;
            this.drawnAt = -Infinity;
            // One scale for all tilts.
            const scored = (card.map.size * card.map.pitch) / 2;
            this.halfWidth = Math.max(scored, data.table.halfWidths[card.place]);
            this.litFacets = [];
            this.listen();
        }

        /** Functions from the view to the canvas and back, for a canvas of this width. */
        scale(width) {
            const pixels = ((1 - 2 * MAP_MARGIN) * width) / (2 * this.halfWidth);
            return {
                pixels,
                toCanvas: (x, y) => [width / 2 + pixels * x, width / 2 - pixels * y],
                toView: (u, v) => ({ x: (u - width / 2) / pixels, y: (width / 2 - v) / pixels }),
            };
        }

        draw() {
            this.drawnAt = performance.now();
            const { context, width } = fitted(this.canvas);
            const { toCanvas, pixels } = this.scale(width);
            const { map, stone, path, view } = this.card;
            const [viewRight, viewUp, viewEye] = view.basis;
            const onCanvas = (p) => toCanvas(dot(p, viewRight), dot(p, viewUp));
            context.clearRect(0, 0, width, width);
            const [left, top] = toCanvas(map.start - map.pitch / 2, -map.start + map.pitch / 2);
            const side = map.size * map.pitch * pixels;
            context.imageSmoothingEnabled = side * context.getTransform().a < 2 * map.size;
            context.imageSmoothingQuality = 'high';
            context.globalAlpha = lights.kind === null ? 1 : FADED;
            context.drawImage(map.picture(), left, top, side, side);
            context.globalAlpha = 1;
            if (lights.kind !== null) context.drawImage(map.picture(lights.kind), left, top, side, side);
            if (this.withLines) {
                const seen = this.card.geometry.outlines.filter(({ facets }) =>
                    facets.some((facet) => this.card.facesEye(facet, viewEye)),
                );
                beginLines(context, seen.map(({ from, to }) => [onCanvas(from), onCanvas(to)]));
                context.lineWidth = 1;
                context.strokeStyle = 'rgb(255 255 255 / 0.75)';
                context.stroke();
            }
            const outlines = this.card.isScored ? (stone.virtualFacets?.outlines ?? []) : [];
            const outlined = (numbers) => {
                context.beginPath();
                for (const number of numbers) {
                    const outline = outlines[number];
                    context.moveTo(...toCanvas(outline[0], outline[1]));
                    for (let k = 2; k < outline.length; k += 2) context.lineTo(...toCanvas(outline[k], outline[k + 1]));
                    context.closePath();
                }
            };
            if (this.withVirtual) {
                outlined(outlines.keys());
                context.lineWidth = 0.7;
                context.strokeStyle = 'rgb(0 0 0 / 0.6)';
                context.stroke();
            }
            if (outlines.length && this.litFacets.length) {
                outlined(this.litFacets);
                for (const [style, lineWidth] of [['#000000', 4], ['#ffffff', 2]]) {
                    context.strokeStyle = style;
                    context.lineWidth = lineWidth;
                    context.stroke();
                }
            }
            if (path === null) return;

            const marker = toCanvas(this.card.point.x, this.card.point.y);
            if (path.status !== STATUS.MISSED) {
                const colour = rayColour(path);
                const lines = lightLines(path).map((ends) => ends.map(onCanvas));
                beginLines(context, lines);
                context.lineCap = context.lineJoin = 'round';
                const halo = path.rear ? '#000000' : '#ffffff';
                for (const [style, lineWidth] of [[halo, 2 * rayWidth(path)], [colour, rayWidth(path)]]) {
                    context.strokeStyle = style;
                    context.lineWidth = lineWidth;
                    context.stroke();
                }
                if (lines.length <= MOST_NUMBERED + 2) {
                    drawArrows(context, lines, halo, 8);
                    drawArrows(context, lines, colour, 5.5);
                }
            }
            for (const [style, lineWidth] of [['#000000', 4.6], ['#ffffff', 2.2]]) {
                context.beginPath();
                context.arc(...marker, 6.5, 0, 2 * Math.PI);
                context.strokeStyle = style;
                context.lineWidth = lineWidth;
                context.stroke();
            }
        }

        /** Bring out some virtual facets, by their numbers. */
        light(facets) {
            const isSame = facets.length === this.litFacets.length && facets.every((f, i) => f === this.litFacets[i]);
            if (isSame) return;
            this.litFacets = facets;
            this.card.redrawMap();
        }

        /** The number of the virtual facet at a point of the view; -1 for none. */
        facetAt({ x, y }) {
            const outlines = this.card.isScored ? (this.card.stone.virtualFacets?.outlines ?? []) : [];
            return outlines.findIndex((outline) => {
                for (let k = 0; k < outline.length; k += 2) {
                    const next = (k + 2) % outline.length;
                    const [ax, ay] = [outline[k], outline[k + 1]];
                    // Convex and anticlockwise: a point inside is left of every edge.
                    if ((outline[next] - ax) * (y - ay) < (outline[next + 1] - ay) * (x - ax)) return false;
                }
                return true;
            });
        }

        at(event) {
            const box = this.canvas.getBoundingClientRect();
            return this.scale(box.width).toView(event.clientX - box.left, event.clientY - box.top);
        }

        listen() {
            this.canvas.addEventListener('click', (event) => {
                const isPlaced = event.clientX !== 0 || event.clientY !== 0; // not made by a program
                if (isPlaced) choose(this.at(event), this.card);
            });
            this.canvas.addEventListener('pointermove', (event) => {
                if (event.pointerType === 'touch') return;
                const { map } = this.card;
                const pixel = map.pixelAt(this.at(event));
                const code = map.code(pixel);
                this.card.pointAt(kinds[code], code === codes.outside ? -1 : this.facetAt(map.point(pixel)));
                if (code === codes.outside) return tip.hide();
                const path = this.card.trace(map.point(pixel));
                const facet = path.facets.length ? `${facetName(this.card.stone.facetNames[path.facets[0]])}: ` : '';
                const value = code < codes.rear ? `${number((code + 0.5) / codes.steps, 1)} %` : null;
                tip.show(event, facet + (value ?? (code === codes.rear ? 'rear light' : 'trapped')));
            });
            this.canvas.addEventListener('pointerleave', () => {
                this.card.pointAt(OUTSIDE, -1);
                tip.hide();
            });
            this.canvas.addEventListener('keydown', (event) => {
                const moves = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };
                if (!moves[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
                event.preventDefault();
                const { map } = this.card;
                const step = STEPS[event.shiftKey ? 1 : 0] * Math.ceil(map.size / 1024);
                const [rows, columns] = moves[event.key].map((n) => n * step);
                const inside = (n) => Math.min(Math.max(n, 0), map.size - 1);
                const { row, column } = this.card.pixel;
                choose(map.point({ row: inside(row + rows), column: inside(column + columns) }), this.card);
            });
            const { virtualFacets } = this.card.stone;
            for (const [name, property] of [['lines', 'withLines'], ['virtual', 'withVirtual']]) {
                const button = find(this.root, `[data-${name}]`);
                if (name === 'virtual' && virtualFacets === null) {
                    button.remove();
                    continue;
                }
                if (name === 'virtual') button.textContent = `${virtualFacets.number} virtual facets`;
                button.addEventListener('click', () => {
                    this[property] = !this[property];
                    button.setAttribute('aria-pressed', String(this[property]));
                    this.card.redrawMap();
                });
            }
        }
    }

    return Object.freeze({ MapView });
})();
