'use strict';

// What is drawn of a stone: its map, as it was scored or traced here for another tilt, and its faces and edges.

const GemStone = (() => {
    const { element } = GemDom;
    const { codes } = GemPage.data;
    const { kinds, painted, codeOf } = GemLight;

    /** Pixels a side of the map of a tilted view, which is traced in the page: of blocks first, then all. */
    const TRACED_PIXELS = 384;
    const COARSEST = 16;

    /** A map: codes of its pixels, and the ray through each. */
    class CodedMap {
        constructor({ size, start, pitch }) {
            Object.assign(this, { size, start, pitch, codes: null, pictures: new Map() });
        }

        /** Row and column of the pixel nearest to a point of the view. */
        pixelAt({ x, y }) {
            const place = (value) =>
                Math.min(Math.max(Math.round((value - this.start) / this.pitch), 0), this.size - 1);
            return { row: place(-y), column: place(x) };
        }

        point({ row, column }) {
            return { x: this.start + column * this.pitch, y: -this.start - row * this.pitch };
        }

        code({ row, column }) {
            return this.codes[row * this.size + column];
        }

        /** The map in its colours, one pixel a pixel: all of it, or what is of one kind. */
        picture(kind = null) {
            if (!this.pictures.has(kind)) {
                const canvas = element('canvas', { width: this.size, height: this.size });
                const context = canvas.getContext('2d');
                const image = context.createImageData(this.size, this.size);
                const pixels = new Uint32Array(image.data.buffer);
                for (let i = 0; i < pixels.length; i++)
                    if (kind === null || kinds[this.codes[i]] === kind) pixels[i] = painted[this.codes[i]];
                context.putImageData(image, 0, 0);
                this.pictures.set(kind, canvas);
            }
            return this.pictures.get(kind);
        }
    }

    /** The map that was scored. */
    class ScoredMap extends CodedMap {
        constructor(map) {
            super(map);
            this.text = map.data;
            this.isDone = true;
        }

        async load() {
            const packed = Uint8Array.from(atob(this.text), (letter) => letter.charCodeAt(0));
            const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
            const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
            const count = this.size ** 2;
            this.codes = new Uint16Array(count);
            for (let i = 0; i < count; i++) {
                const before = i % this.size ? this.codes[i - 1] : 0;
                this.codes[i] = before + (bytes[i] << 8) + bytes[count + i]; // modulo 2^16
            }
            this.text = null;
        }
    }

    /** The map of another view, traced here: by every sixteenth pixel first, then by every eighth, to all. */
    class TracedMap extends CodedMap {
        constructor(trace, halfWidth) {
            const pitch = (2 * halfWidth) / TRACED_PIXELS;
            super({ size: TRACED_PIXELS, start: pitch / 2 - halfWidth, pitch });
            Object.assign(this, { ray: trace, stride: COARSEST, next: 0 });
            this.codes = new Uint16Array(this.size ** 2).fill(codes.outside);
            this.isKnown = new Uint8Array(this.size ** 2);
        }

        get isDone() {
            return this.stride < 1;
        }

        code({ row, column }) {
            const i = row * this.size + column;
            if (!this.isKnown[i]) {
                this.codes[i] = codeOf(this.ray(this.point({ row, column })));
                this.isKnown[i] = 1;
            }
            return this.codes[i];
        }

        /** Trace on, until a time [ms] or to the end. */
        trace(until) {
            while (!this.isDone) {
                const { size, stride } = this;
                const across = Math.ceil(size / stride);
                if (this.next === across ** 2) {
                    this.stride = stride > 1 ? stride / 2 : 0;
                    this.next = 0;
                    continue;
                }
                const [row, column] = [Math.floor(this.next / across) * stride, (this.next % across) * stride];
                const code = this.code({ row, column });
                for (let v = row; v < Math.min(row + stride, size); v++)
                    for (let u = column; u < Math.min(column + stride, size); u++)
                        if (!this.isKnown[v * size + u]) this.codes[v * size + u] = code;
                this.next += 1;
                if (this.next % 16 === 0 && performance.now() > until) break;
            }
            this.pictures.clear();
        }
    }

    /** The drawing's faces and the edges between its facets. */
    function geometryOf({ mesh: { vertices, faces, facets }, wall, round }) {
        const positions = [];
        const normals = [];
        const edges = new Map();
        faces.forEach((face, i) => {
            const corners = face.map((v) => vertices[v]);
            const isRound = round && facets[i] === wall;
            const [a, b, c] = corners;
            const flat = GemTracer.unit(
                GemTracer.cross(b.map((x, k) => x - a[k]), c.map((x, k) => x - a[k])),
            );
            for (const corner of corners) {
                positions.push(...corner);
                normals.push(...(isRound ? GemTracer.unit([corner[0], corner[1], 0]) : flat));
            }
            face.forEach((v, k) => {
                const next = face[(k + 1) % 3];
                const key = v < next ? `${v} ${next}` : `${next} ${v}`;
                const edge = edges.get(key);
                if (!edge) edges.set(key, { ends: [v, next], facets: [facets[i]], normals: [flat] });
                else {
                    edge.facets.push(facets[i]);
                    edge.normals.push(flat);
                }
            });
        });
        const isOutline = ({ facets: [first, second] }) => first !== second;
        const drawn = [...edges.values()].map((edge) => ({
            ...edge, from: vertices[edge.ends[0]], to: vertices[edge.ends[1]],
        }));
        return {
            positions,
            normals,
            outlines: drawn.filter(isOutline),
            // Within a girdle that is not plane an edge is drawn only where it turns away from the eye.
            wall: drawn.filter((edge) => !isOutline(edge) && edge.facets[0] === wall),
        };
    }

    return Object.freeze({ ScoredMap, TracedMap, geometryOf });
})();
