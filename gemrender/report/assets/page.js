'use strict';

// The page: for each stone a stage (3D), a map and the ray through the chosen point, linked with each other and
// with the other stones. Uses THREE (three.min.js), GemTracer (tracer.js) and GemScores (scores.js); all data is
// in #data.

(() => {
    const { STATUS, dot } = GemTracer;
    const { number, find, element } = GemDom;
    const { boundText } = GemScores;
    const data = JSON.parse(document.getElementById('data').textContent);
    const { colours, codes } = data;

    /** Canvases are drawn at least at this many pixels a CSS pixel: for sharp paper too. */
    const LEAST_PIXEL_RATIO = 2;
    /** Most rows of a path's table, and most reflections that are numbered in the drawings. */
    const MOST_ROWS = 60;
    const MOST_NUMBERED = 16;
    /** Most stones that have a column each in the tables below. */
    const MOST_COLUMNS = 4;
    /** Length of the ray drawn outside the stone [stone's unit]. */
    const OUTSIDE_LENGTH = 0.55;
    /** The map's margin around the stone, as a share of its width. */
    const MAP_MARGIN = 0.03;
    /** Pixels that the point moves by an arrow key, and with Shift. */
    const STEPS = [1, 16];
    /** Largest difference between the map and the ray traced here that is rounding [%]. */
    const SAME_INTENSITY = 0.05;
    /** A press that moves less than this is a click [CSS px]. */
    const CLICK_SLACK = 5;
    /** Pixels a side of the map of a tilted view, which is traced in the page: of blocks first, then all. */
    const TRACED_PIXELS = 384;
    const COARSEST = 16;
    /** Time for it in each frame, and before the first one [ms]; so many finished ones are kept for all stones. */
    const TRACING_TIME = 12;
    const FIRST_TIME = 30;
    const MOST_TRACED = 48;
    /** How much is left of the map beside the band that is pointed at. */
    const FADED = 0.14;
    const PAPER = matchMedia('print');
    /** What is rear light, by the model's rule. */
    const REAR_WORDS = {
        position: 'Light that comes in at or below height 0, the girdle’s lower edge, is rear light.',
        facet: 'Light that comes in through a facet of the pavilion is rear light.',
        direction: 'Light that comes from below the horizon is rear light.',
    };

    const STAGE_FONT = '600 11px "Segoe UI", Roboto, Helvetica, Arial, sans-serif';
    const REAR_RAY = '#ffffff';
    const STAGE_GLOW = ['#1d2530', '#0b0e13'];

    const facetName = (name) => name.replace(/^bezel_/, 'bezel_main_').replaceAll('_', ' ');
    /** A facet within a sentence: a word, such as "the table" or "star 1", or a designer's name: "facet P1 24". */
    function theFacet(name) {
        if (!/^[a-z]{3}/.test(name)) return `facet ${facetName(name)}`;
        return (/_/.test(name) ? '' : 'the ') + facetName(name);
    }
    const times = (count) => (count === 1 ? 'once' : count === 2 ? 'twice' : `${count} times`);

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

    /** Fit a canvas to its place in the page; returns its context, scaled to CSS pixels, and its width. */
    function fitted(canvas) {
        const ratio = Math.max(window.devicePixelRatio || 1, LEAST_PIXEL_RATIO);
        const width = canvas.clientWidth || canvas.width / ratio;
        const pixels = Math.max(Math.round(width * ratio), 1);
        if (canvas.width !== pixels) canvas.width = canvas.height = pixels;
        const context = canvas.getContext('2d');
        context.setTransform(pixels / width, 0, 0, pixels / width, 0, 0);
        return { context, width, pixels };
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

    /** Distance of a place on a canvas from a line there. */
    function distanceTo([[ax, ay], [bx, by]], [x, y]) {
        const [dx, dy] = [bx - ax, by - ay];
        const share = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1);
        const nearest = Math.min(Math.max(share, 0), 1);
        return Math.hypot(ax + nearest * dx - x, ay + nearest * dy - y);
    }

    // ---- The data of a stone ---------------------------------------------------------------------------

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

    // ---- The stage: the stone in 3D --------------------------------------------------------------------

    const FACET_SHADER = {
        vertexShader: `
            varying vec3 n;
            void main() {
                n = normal;
                gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
            }`,
        fragmentShader: `
            uniform vec3 eye;
            uniform vec3 lamp;
            uniform float strength;
            uniform float highlight;
            varying vec3 n;
            void main() {
                vec3 normal = normalize(n);
                float facing = abs(dot(normal, eye));
                float rim = pow(1.0 - facing, 2.5);
                float light = max(dot(normal, lamp), 0.0);
                float glint = pow(max(dot(reflect(-eye, normal), lamp), 0.0), 24.0);
                vec3 colour = mix(vec3(0.45, 0.58, 0.74), vec3(0.86, 0.93, 1.0), light);
                float alpha = strength * (0.05 + 0.16 * light + 0.22 * rim + 0.30 * glint);
                gl_FragColor = mix(vec4(colour, alpha), vec4(1.0, 0.80, 0.68, 0.16), highlight);
            }`,
    };

    const VIEWS = {
        tilted: { azimuth: -62, elevation: 24 },
        top: { azimuth: -90, elevation: 90 },
        side: { azimuth: -90, elevation: 0 },
        below: { azimuth: -90, elevation: -90 },
    };
    /** The room beside the stone, and above and below it [stone's unit]. */
    const ASIDE = 0.26;
    const MARGIN = 0.45;
    /** By how much the stage's centre lies above the stone's, for the rays that come and go there. */
    const RAISED = 0.19;
    const ZOOMS = [0.7, 8];

    /** One drawing surface for all stages: browsers allow few. */
    let shared; // undefined: not asked for yet; null: this browser has none
    function renderer() {
        if (shared === undefined) {
            try {
                shared = new THREE.WebGLRenderer({ antialias: true, alpha: true });
                shared.autoClear = false;
                shared.setPixelRatio(1);
                shared.domElement.addEventListener('webglcontextrestored', () => cards.forEach((card) => card.redraw()));
            } catch {
                shared = null;
            }
        }
        return shared;
    }

    function setLines(lines, positions) {
        lines.geometry.dispose();
        lines.geometry = new THREE.LineSegmentsGeometry();
        lines.geometry.setPositions(positions);
    }

    class Stage {
        constructor(root, card) {
            this.card = card;
            this.canvas = find(root, 'canvas');
            this.canvas.setAttribute(
                'aria-label',
                `${card.stone.name} in 3D. Arrow keys turn it, plus and minus zoom, 0 brings it back.`,
            );
            find(root, '.failure').hidden = renderer() !== null;
            this.build();
            this.show('tilted');
            this.listen(root);
        }

        build() {
            const { positions, normals, outlines, wall } = this.card.geometry;
            this.wall = wall;
            const geometry = new THREE.BufferGeometry();
            geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(positions), 3));
            geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(normals), 3));
            this.uniforms = { eye: { value: new THREE.Vector3() }, lamp: { value: new THREE.Vector3() } };
            const facets = (side, strength) =>
                new THREE.Mesh(
                    geometry,
                    new THREE.ShaderMaterial({
                        ...FACET_SHADER,
                        uniforms: { ...this.uniforms, strength: { value: strength }, highlight: { value: 0 } },
                        side,
                        transparent: true,
                        depthTest: false,
                        depthWrite: false,
                    }),
                );
            const lines = (colour, opacity, width, depthTest) =>
                new THREE.LineSegments2(
                    new THREE.LineSegmentsGeometry(),
                    new THREE.LineMaterial({
                        color: colour,
                        opacity,
                        linewidth: width,
                        transparent: opacity < 1,
                        depthTest,
                        depthWrite: opacity === 1,
                    }),
                );
            const outline = outlines.flatMap(({ from, to }) => [...from, ...to]);
            const depth = new THREE.MeshBasicMaterial({
                colorWrite: false,
                polygonOffset: true,
                polygonOffsetFactor: 1,
                polygonOffsetUnits: 4,
            });
            this.hidden = lines('#9fb6d3', 0.3, 1, false);
            this.visible = lines('#dfe9f7', 0.9, 1.35, true);
            this.silhouette = lines('#dfe9f7', 0.9, 1.35, false);
            this.ray = lines('#ffffff', 1, 2.6, true);
            this.met = facets(THREE.DoubleSide, 1);
            this.met.geometry = new THREE.BufferGeometry();
            this.met.material.uniforms.highlight = { value: 1 };
            for (const drawn of [this.hidden, this.visible]) drawn.geometry.setPositions(outline);
            this.ray.visible = false;
            // From the back to the front: far facets, far edges, the ray, near facets, near edges.
            this.scene = new THREE.Scene();
            this.scene.add(
                facets(THREE.BackSide, 0.8),
                this.hidden,
                this.met,
                this.ray,
                facets(THREE.FrontSide, 1),
                new THREE.Mesh(geometry, depth),
                this.visible,
                this.silhouette,
            );
            this.scene.children.forEach((child, order) => {
                child.renderOrder = order;
                child.frustumCulled = false;
                child.material.transparent = true; // all in one queue, sorted by that order
            });
            this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 40);
            const { vertices } = this.card.stone.mesh;
            const heights = vertices.map((v) => v[2]);
            const [bottom, top] = [Math.min(...heights), Math.max(...heights)];
            this.centre = [0, 0, (bottom + top) / 2 + RAISED];
            const reach = Math.max(...vertices.map(([x, y]) => Math.hypot(x, y)));
            this.extent = Math.max(reach + ASIDE, (top - bottom) / 2 + MARGIN);
        }

        show(name) {
            Object.assign(this, VIEWS[name], { zoom: 1 });
            this.card.redraw();
        }

        turn(azimuth, elevation) {
            this.azimuth += azimuth;
            this.elevation = Math.min(Math.max(this.elevation + elevation, -90), 90);
            this.card.redraw();
        }

        zoomBy(factor) {
            this.zoom = Math.min(Math.max(this.zoom * factor, ZOOMS[0]), ZOOMS[1]);
            this.card.redraw();
        }

        /** The view's right, its up and the direction to the eye. */
        basis() {
            const [azimuth, elevation] = [this.azimuth, this.elevation].map((angle) => (angle * Math.PI) / 180);
            const [ca, sa, ce, se] = [
                Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation),
            ];
            return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
        }

        draw() {
            const { context, width, pixels } = fitted(this.canvas);
            const glow = context.createRadialGradient(
                width / 2, width * 0.46, 0, width / 2, width * 0.46, width * 0.72,
            );
            STAGE_GLOW.forEach((colour, i) => glow.addColorStop(i, colour));
            context.fillStyle = glow;
            context.fillRect(0, 0, width, width);
            const [right, up, eye] = this.basis();
            const half = this.extent / this.zoom;
            const path = this.card.path;
            const isShown = path !== null && path.status !== STATUS.MISSED;
            if (renderer()) {
                this.uniforms.eye.value.set(...eye);
                const lamp = right.map((r, i) => -0.45 * r + 0.6 * up[i] + 0.66 * eye[i]);
                this.uniforms.lamp.value.set(...GemTracer.unit(lamp));
                Object.assign(this.camera, { left: -half, right: half, top: half, bottom: -half });
                this.camera.up.set(...up);
                this.camera.position.set(...this.centre.map((c, i) => c + 20 * eye[i]));
                this.camera.lookAt(...this.centre);
                this.camera.updateProjectionMatrix();
                this.ray.visible = isShown;
                this.outlineWall(eye);
                for (const lines of [this.hidden, this.visible, this.silhouette, this.ray]) {
                    lines.userData.width ??= lines.material.linewidth;
                    lines.material.linewidth = (lines.userData.width * pixels) / width;
                    lines.material.resolution.set(pixels, pixels);
                }
                renderer().setSize(pixels, pixels, false);
                renderer().clear();
                renderer().render(this.scene, this.camera);
                context.drawImage(renderer().domElement, 0, 0, width, width);
            }
            if (!isShown) return;

            const scale = width / (2 * half);
            const onCanvas = (p) => {
                const q = p.map((value, i) => value - this.centre[i]);
                return [width / 2 + scale * dot(q, right), width / 2 - scale * dot(q, up)];
            };
            const lines = lightLines(path).map((ends) => ends.map(onCanvas));
            if (lines.length <= MOST_NUMBERED + 2) drawArrows(context, lines, rayColour(path), 5.5);
            this.drawLabels(context, stationNames(path), path.points.map(onCanvas), lines, width);
        }

        /** Outline the girdle's wall where it turns away from the eye. */
        outlineWall(eye) {
            const ends = this.wall
                .filter(({ normals: [first, second] }) => dot(first, eye) > 0 !== dot(second, eye) > 0)
                .flatMap(({ from, to }) => [...from, ...to]);
            this.silhouette.visible = ends.length > 0;
            if (ends.length > 0) setLines(this.silhouette, ends);
        }

        /** Number the points, where there is room. */
        drawLabels(context, names, places, lines, width) {
            const centre = places.reduce(([x, y], p) => [x + p[0] / places.length, y + p[1] / places.length], [0, 0]);
            const taken = [];
            context.font = STAGE_FONT;
            context.textAlign = 'center';
            context.textBaseline = 'middle';
            const last = places.length - 1;
            // The ends first: they must be named.
            const order = last <= MOST_NUMBERED ? new Set([0, last, ...places.keys()]) : [0, last];
            for (const i of order) {
                const [x, y] = places[i];
                context.fillStyle = '#ffffff';
                context.beginPath();
                context.arc(x, y, 2.6, 0, 2 * Math.PI);
                context.fill();
                const half = context.measureText(names[i]).width / 2 + 4.5;
                const away = Math.atan2(y - centre[1], x - centre[0]);
                // Away from the middle of the path, else where the ray is farthest.
                const spots = [0, 0.8, -0.8, 1.6, -1.6, 2.4, -2.4, Math.PI]
                    .map((turn) => [x + (half + 8) * Math.cos(away + turn), y + 15 * Math.sin(away + turn)])
                    .filter(
                        ([u, v]) =>
                            u > half && u < width - half && v > 9 && v < width - 9 &&
                            !taken.some((t) => Math.abs(t.u - u) < t.half + half + 1 && Math.abs(t.v - v) < 18),
                    )
                    .map((at) => ({ at, room: Math.min(...lines.map((line) => distanceTo(line, at))) }));
                if (spots.length === 0) continue;
                const roomy = spots.find(({ room }) => room > half + 2);
                const [u, v] = (roomy ?? spots.reduce((a, b) => (b.room > a.room ? b : a))).at;
                taken.push({ u, v, half });
                context.fillStyle = 'rgb(9 11 15 / 0.82)';
                context.beginPath();
                context.roundRect(u - half, v - 8, 2 * half, 16, 4);
                context.fill();
                context.fillStyle = '#f2f4f8';
                context.fillText(names[i], u, v + 0.5);
            }
        }

        /** Update the ray that is drawn. */
        setPath(path) {
            if (path === null || path.status === STATUS.MISSED) return;
            setLines(this.ray, lightLines(path).flat(2));
            this.ray.userData.width = rayWidth(path);
            const { mesh: { vertices, faces, facets }, wall } = this.card.stone;
            const met = new Set(path.facets.filter((facet) => facet !== wall));
            const corners = faces.filter((_, i) => met.has(facets[i])).flat(2).flatMap((v) => vertices[v]);
            this.met.visible = met.size <= MOST_NUMBERED;
            this.met.geometry.dispose();
            this.met.geometry = new THREE.BufferGeometry();
            this.met.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(corners), 3));
            this.met.geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(corners), 3));
            this.ray.material.color.set(rayColour(path));
        }

        /** The point of the map whose ray meets the stone where the eye sees this point of the canvas. */
        pick(event) {
            const box = this.canvas.getBoundingClientRect();
            const [right, up, eye] = this.basis();
            const scale = (2 * this.extent) / this.zoom / box.width;
            const u = (event.clientX - box.left - box.width / 2) * scale;
            const v = (box.top + box.height / 2 - event.clientY) * scale;
            const from = this.centre.map((c, i) => c + u * right[i] + v * up[i] + 20 * eye[i]);
            const hit = this.card.surfaces.nearest(from, eye.map((x) => -x), false);
            const [viewRight, viewUp, viewEye] = this.card.view.basis;
            if (!hit || dot(hit.normal, viewEye) <= 0) return null;
            return { x: dot(hit.point, viewRight), y: dot(hit.point, viewUp) };
        }

        listen(root) {
            const pointers = new Map();
            let travelled = 0;
            let span = 0;
            const spread = () => {
                const [a, b] = [...pointers.values()];
                return Math.hypot(a.x - b.x, a.y - b.y);
            };
            this.canvas.addEventListener('pointerdown', (event) => {
                this.canvas.setPointerCapture(event.pointerId);
                pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
                if (pointers.size === 1) travelled = 0;
                if (pointers.size === 2) span = spread();
            });
            this.canvas.addEventListener('pointermove', (event) => {
                const before = pointers.get(event.pointerId);
                if (!before) return;
                const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
                pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
                travelled += Math.hypot(dx, dy);
                if (pointers.size === 2) {
                    const now = spread();
                    if (span > 0) this.zoomBy(now / span);
                    span = now;
                } else if (travelled > CLICK_SLACK) {
                    this.canvas.classList.add('turning');
                    this.turn(-0.45 * dx, 0.45 * dy);
                }
            });
            const release = (event) => {
                const wasDown = pointers.delete(event.pointerId);
                if (pointers.size === 0) this.canvas.classList.remove('turning');
                else travelled = Infinity; // one of two fingers left: no click
                if (!wasDown || event.type !== 'pointerup' || travelled > CLICK_SLACK) return;
                const point = this.pick(event);
                if (point) choose(point, this.card);
                else announce('Only facets that the eye of the map sees can be chosen.');
            };
            this.canvas.addEventListener('pointerup', release);
            this.canvas.addEventListener('pointercancel', release);
            // The wheel scrolls the page, and zooms with Ctrl or while the stone has the focus.
            this.canvas.addEventListener('wheel', (event) => {
                if (!event.ctrlKey && document.activeElement !== this.canvas) return;
                event.preventDefault();
                this.zoomBy(Math.exp(-0.0015 * event.deltaY));
            }, { passive: false });
            this.canvas.addEventListener('keydown', (event) => {
                if (event.ctrlKey || event.metaKey || event.altKey) return;
                const step = event.shiftKey ? 30 : 5;
                const actions = {
                    ArrowLeft: () => this.turn(step, 0),
                    ArrowRight: () => this.turn(-step, 0),
                    ArrowUp: () => this.turn(0, -step),
                    ArrowDown: () => this.turn(0, step),
                    '+': () => this.zoomBy(1.2),
                    '=': () => this.zoomBy(1.2),
                    '-': () => this.zoomBy(1 / 1.2),
                    0: () => this.show('tilted'),
                    Home: () => this.show('tilted'),
                };
                if (!actions[event.key]) return;
                event.preventDefault();
                actions[event.key]();
            });
            for (const button of root.querySelectorAll('[data-view]'))
                button.addEventListener('click', () => this.show(button.dataset.view));
            for (const button of root.querySelectorAll('[data-zoom]'))
                button.addEventListener('click', () => this.zoomBy(button.dataset.zoom === 'in' ? 1.25 : 0.8));
        }
    }

    // ---- The map ---------------------------------------------------------------------------------------

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
            // One scale for all tilts.
            const scored = (card.map.size * card.map.pitch) / 2;
            this.halfWidth = Math.max(scored, data.table.halfWidths[card.place]);
            this.litFacets = [];
            this.isWaiting = false;
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
                context.beginPath();
                for (const { from, to, facets } of this.card.geometry.outlines) {
                    if (!facets.some((facet) => this.card.facesEye(facet, viewEye))) continue;
                    context.moveTo(...onCanvas(from));
                    context.lineTo(...onCanvas(to));
                }
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
                context.beginPath();
                for (const [from, to] of lines) {
                    context.moveTo(...from);
                    context.lineTo(...to);
                }
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

        /** Draw again in the next frame. */
        redraw() {
            if (this.isWaiting) return;
            this.isWaiting = true;
            requestAnimationFrame(() => {
                this.isWaiting = false;
                this.draw();
            });
        }

        /** Bring out some virtual facets, by their numbers. */
        light(facets) {
            const isSame = facets.length === this.litFacets.length && facets.every((f, i) => f === this.litFacets[i]);
            if (isSame) return;
            this.litFacets = facets;
            this.redraw();
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
                    this.card.redraw();
                });
            }
        }
    }

    // ---- A stone: stage, map, scores, ray --------------------------------------------------------------

    class Card {
        constructor(stone, place) {
            Object.assign(this, { stone, place, view: stone.view, isScored: true });
            this.map = this.scored = new ScoredMap(stone.map);
            this.traced = new Map();
            this.surfaces = GemTracer.surfacesOf(stone.solid);
            this.geometry = geometryOf(stone);
            this.path = null;
            this.pixel = null;
            this.isWaiting = false;
            this.isInSight = true;
            const made = document.getElementById('stone').content.cloneNode(true);
            this.root = find(made, 'article');
        }

        async build(parent) {
            await this.map.load();
            const { root, stone } = this;
            root.setAttribute('aria-label', stone.name);
            find(root, '.name').textContent = stone.name;
            find(root, '.name').hidden = data.stones.length === 1;
            parent.append(root);
            this.stage = new Stage(find(root, '.stage'), this);
            this.mapView = new MapView(find(root, '.map'), this);
            this.fillScores();
            this.fillAlike();
            new ResizeObserver(() => this.redraw()).observe(root);
            new IntersectionObserver(([entry]) => {
                this.isInSight = entry.isIntersecting;
                if (this.isInSight && this.isStale) this.redraw();
                traceOn();
            }, { rootMargin: '50%' }).observe(root);
        }

        fillScores() {
            const { root, stone, place } = this;
            const { turn } = choices;
            const value = (key) => values.value(place, turn, key);
            for (const key of ['average', 'rear']) {
                const bound = values.bound(place, turn, key);
                const within = bound === null ? [] : [element('small', { className: 'bound' }, `±${boundText(bound)}`)];
                find(root, `.${key}`).replaceChildren(number(value(key), 2), element('small', {}, ' %'), ...within);
            }
            const ofBands = values.columns.filter(({ band }) => band !== null);
            const rows = ofBands.map(({ key, band }) => [band, stone.score.bands[band].name, value(key)]);
            rows.push([REAR, 'Rear', value('rear')]);
            const unsolved = (value('trapped') ?? 0) + (value('lost') ?? 0);
            if (unsolved > 0) rows.push([UNSOLVED, 'Trapped', unsolved]);
            const widest = Math.max(...rows.map((row) => row[2]));
            const made = rows.map(([kind, name, share]) => {
                const bar = element('i');
                bar.style.background = kindColour(kind);
                bar.style.width = `${(62 * share) / widest}%`;
                const line = element('div', { className: 'bar' }, ...(share > 0 ? [bar] : []), element('span', {}, shareText(share)));
                const row = lightingRow(kind, name, line);
                row.dataset.kind = kind;
                hoverable(row, () => lights.point(kind), () => lights.point(null), () => lights.hold(kind));
                return row;
            });
            find(root, '.shares tbody').replaceChildren(...made);
            lights.show();
        }

        /** The largest virtual facets, those alike in one row. */
        fillAlike() {
            const { virtualFacets } = this.stone;
            const table = find(this.root, '.alike');
            this.alike = virtualFacets?.alike ?? [];
            this.held = null;
            table.hidden = this.alike.length === 0;
            this.alikeRows = this.alike.map(({ share, intensity, rear, members }, i) => {
                const kind = rear ? REAR : kindOf(intensity * codes.steps);
                const name = `${members.length > 1 ? `${members.length} × ` : ''}${number(share, 3)} %`;
                const row = lightingRow(kind, name, element('span', {}, rear ? 'rear light' : `${number(intensity, 1)} %`));
                const show = (pointed) => this.mapView.light(pointed ?? this.alike[this.held]?.members ?? []);
                hoverable(row, () => show(members), () => show(null), () => {
                    this.held = this.held === i ? null : i;
                    this.alikeRows.forEach((each, k) => press(each, k === this.held));
                    show(null);
                });
                return row;
            });
            find(table, 'tbody').replaceChildren(...this.alikeRows);
        }

        /** Bring out in the tables what is pointed at in the map: a kind of light, and a virtual facet. */
        pointAt(kind, facet) {
            for (const row of this.root.querySelectorAll('[data-kind]'))
                row.classList.toggle('lit', Number(row.dataset.kind) === kind);
            scoreTable.mark(this.place, kind === REAR ? 'rear' : kind >= 0 ? kind : null);
            this.alikeRows.forEach((row, i) => row.classList.toggle('lit', this.alike[i].members.includes(facet)));
            this.mapView.light(facet >= 0 ? [facet] : (this.alike[this.held]?.members ?? []));
        }

        /** Show the stone at another tilt: its map, its scores, and the ray through the same point. */
        setTurn() {
            const { turn } = choices;
            this.isScored = values.turns[turn] === 0;
            this.view = this.isScored ? this.stone.view : { ...this.stone.view, basis: values.bases[turn] };
            this.map = this.isScored ? this.scored : this.tracedMap(turn);
            find(this.root, '.alike').hidden = !this.isScored || this.alike.length === 0;
            const button = find(this.root, '[data-virtual]');
            if (button) button.disabled = !this.isScored;
            this.fillScores();
        }

        tracedMap(turn) {
            const found = this.traced.get(turn) ?? new TracedMap((point) => this.trace(point, values.bases[turn]), this.mapView.halfWidth);
            this.traced.delete(turn);
            this.traced.set(turn, found); // the last one used is the last one
            const [oldest] = this.traced.keys();
            if (this.traced.size > Math.max(2, MOST_TRACED / cards.length)) this.traced.delete(oldest);
            if (this.isInSight) found.trace(performance.now() + FIRST_TIME / cards.length);
            return found;
        }

        facesEye(facet, eye) {
            const { solid: { planes, planeFacet }, wall } = this.stone;
            return facet !== wall && dot(planes[planeFacet.indexOf(facet)], eye) > 0;
        }

        trace({ x, y }, basis = this.view.basis) {
            return GemTracer.trace(this.surfaces, data.optics, { basis }, this.stone.model, x, y);
        }

        /** Show the ray through the map's pixel at a point of the view. */
        choose(point) {
            this.pixel = this.map.pixelAt(point);
            this.point = this.map.point(this.pixel);
            this.path = this.trace(this.point);
            this.stage.setPath(this.path);
            this.fillRay();
            this.redraw();
        }

        fillRay() {
            const { root, path, point, stone } = this;
            const code = this.map.code(this.pixel);
            const ray = find(root, '.ray');
            Object.assign(ray.dataset, {
                x: point.x, y: point.y, intensity: path.intensity, status: path.status, rear: path.rear,
                reflections: path.reflections,
            });
            find(root, '.place').textContent = `x ${number(point.x, 3)}, y ${number(point.y, 3)} ${stone.unit}`;
            const isMissed = path.status === STATUS.MISSED;
            const swatch = find(ray, '.swatch');
            swatch.style.background = isMissed ? 'transparent' : pathColour(path);
            find(ray, '.intensity b').replaceChildren(
                ...(isMissed ? ['–'] : [number(path.intensity, 2), element('small', {}, ' %')]),
            );
            this.sentence = sentence(path, stone.facetNames);
            find(ray, '.sentence').textContent = this.sentence;
            find(ray, '.product').replaceChildren(...product(path, stone.model));
            const differs = difference(code, path);
            find(ray, '.differs').hidden = differs === null;
            find(ray, '.differs').textContent = differs ?? '';
            find(ray, '.path').hidden = isMissed;
            find(ray, '.path').scrollTop = 0;
            find(ray, 'tbody').replaceChildren(...pathRows(path, stone.facetNames));
            for (const row of root.querySelectorAll('[data-kind]'))
                row.classList.toggle('here', Number(row.dataset.kind) === kinds[code]);
        }

        redraw() {
            this.isStale = true;
            if (this.isWaiting || !this.isInSight) return;
            this.isWaiting = true;
            requestAnimationFrame(() => {
                this.isWaiting = false;
                this.draw();
            });
        }

        draw() {
            this.isStale = false;
            this.mapView?.draw();
            this.stage?.draw();
        }
    }

    /** A row with a swatch, which can be pointed at and pressed. */
    function lightingRow(kind, name, content) {
        const swatch = element('span', { className: 'swatch' });
        swatch.style.background = kindColour(kind);
        const button = element('button', { type: 'button' }, swatch, name);
        button.setAttribute('aria-pressed', 'false');
        return element('tr', {}, element('th', { scope: 'row' }, button), element('td', {}, content));
    }

    const press = (row, isHeld) => find(row, 'button').setAttribute('aria-pressed', String(isHeld));

    function hoverable(row, enter, leave, click) {
        row.addEventListener('pointerenter', (event) => event.pointerType !== 'touch' && enter());
        row.addEventListener('pointerleave', leave);
        find(row, 'button').addEventListener('click', click);
    }

    /** The band of light that is brought out in all maps: what is pointed at, or was pressed. */
    const lights = {
        pointed: null,
        held: null,
        get kind() {
            return this.pointed ?? this.held;
        },
        point(kind) {
            if (kind === this.pointed) return;
            this.pointed = kind;
            cards.forEach((card) => card.mapView.redraw());
        },
        hold(kind) {
            this.held = this.held === kind ? null : kind;
            this.show();
            cards.forEach((card) => card.mapView.redraw());
        },
        show() {
            for (const row of document.querySelectorAll('[data-kind]'))
                press(row, Number(row.dataset.kind) === this.held);
        },
    };

    function shareText(share) {
        const digits = share === 0 || share >= 0.05 ? 1 : 2 - Math.ceil(Math.log10(share));
        return `${number(share, digits)} %`;
    }

    function pathColour(path) {
        return kindColour(kindOf(codeOf(path)));
    }

    function sentence(path, names) {
        if (path.status === STATUS.MISSED) return 'Outside the stone.';
        const seen = theFacet(names[path.facets[0]]);
        if (path.status === STATUS.TRAPPED)
            return `Seen through ${seen}; no light comes this way: after ${path.reflections} reflections it is still inside.`;
        if (path.status === STATUS.LOST) return `Seen through ${seen}; lost to rounding.`;
        const where = `Light comes in through ${theFacet(names[path.facets.at(-1)])}`;
        const way = path.reflections ? `is totally reflected ${times(path.reflections)} and ` : '';
        const end = `${way}reaches the eye through ${seen}.`;
        if (path.rear) return `${where}: rear light, counted as 0. It ${end}`;
        return where + (way ? `, ${end}` : ` and ${end}`);
    }

    /** The intensity as a product of what both crossings let through. */
    function product(path, model) {
        if (!path.factors) return [];
        const { tIn, sIn, tOut, sOut } = path.factors;
        const factor = (letter, place, value) =>
            element('span', {}, '× ', element('i', {}, letter), element('sub', {}, place), ` ${number(value, 3)}`);
        const isPrimary = model.intensity === 'primary';
        const terms = [
            factor('T', 'in', tIn), ...(isPrimary ? [factor('S', 'in', sIn)] : []),
            factor('T', 'out', tOut), ...(isPrimary ? [factor('S', 'out', sOut)] : []),
        ];
        const value = `${number(100 * tIn * sIn * tOut * sOut, 2)} %`;
        const before = path.rear ? ['Would be '] : [];
        const result = element('span', {}, '= ', path.rear ? value : element('b', {}, value));
        return [...before, '100 %', ...[...terms, result].flatMap((term) => [' ', term])];
    }

    /** What to say where the map's tracer and the page's followed different rays; else null. */
    function difference(code, path) {
        if (code === codes.outside && path.status === STATUS.MISSED) return null;
        const isLit = path.status === STATUS.EXITED && !path.rear;
        const mapped = (code + 0.5) / codes.steps;
        if (code < codes.rear && isLit && Math.abs(mapped - path.intensity) < SAME_INTENSITY) return null;
        if (code === codes.rear && path.status === STATUS.EXITED && path.rear) return null;
        if (code === codes.unsolved && path.status >= STATUS.TRAPPED) return null;
        const names = { [codes.rear]: 'rear light', [codes.unsolved]: 'trapped', [codes.outside]: 'outside the stone' };
        return (
            `The map has ${names[code] ?? `${number(mapped, 2)} %`} here. At the edge of a facet, or after many ` +
            'reflections, rounding decides which way a ray goes.'
        );
    }

    /** The rows of the path's table, in the order in which the light meets the surface. */
    function pathRows(path, facetNames) {
        const names = stationNames(path);
        const isOut = path.status === STATUS.EXITED;
        const last = path.points.length - 1;
        const order = [...path.points.keys()];
        if (isOut) order.reverse();
        const degrees = (angle) => (angle === null ? '' : `${number(angle, 2)}°`);
        const share = (value) => (value === null ? '' : number(value, 3));
        const rows = order.slice(0, MOST_ROWS).map((i) => {
            const [before, after] = GemTracer.anglesAt(path, i);
            let [inStone, inAir, t, s] = [before, null, null, null];
            if (i === 0) {
                [inAir, inStone] = [before, after];
                if (isOut) [t, s] = [path.factors.tOut, path.factors.sOut];
            } else if (isOut && i === last) {
                inAir = after;
                [t, s] = [path.factors.tIn, path.factors.sIn];
            }
            const row = element('tr', {},
                ...[
                    names[i], facetName(facetNames[path.facets[i]]), degrees(inStone), degrees(inAir), share(t), share(s),
                    number(path.points[i][2], 3),
                ].map((text) => element('td', {}, text)),
            );
            row.dataset.facet = facetNames[path.facets[i]];
            return row;
        });
        if (order.length > MOST_ROWS) {
            const cell = element('td', { colSpan: 7 }, `and ${order.length - MOST_ROWS} more`);
            rows.push(element('tr', {}, cell));
        }
        return rows;
    }

    // ---- What the stones share -------------------------------------------------------------------------

    const tip = {
        box: document.getElementById('tip'),
        show(event, text) {
            this.box.textContent = text;
            this.box.hidden = false;
            const { width, height } = this.box.getBoundingClientRect();
            const left = Math.min(event.clientX + 14, document.documentElement.clientWidth - width - 6);
            this.box.style.left = `${left}px`;
            this.box.style.top = `${Math.max(event.clientY - height - 10, 4)}px`;
        },
        hide() {
            this.box.hidden = true;
        },
    };

    let announcing = 0;
    function announce(text) {
        clearTimeout(announcing); // only where the point comes to rest
        announcing = setTimeout(() => {
            document.getElementById('announce').textContent = text;
        }, 350);
    }

    const choices = new GemScores.Choices(data);
    const values = new GemScores.Values(data);
    const cards = data.stones.map((stone, place) => new Card(stone, place));
    let scoreTable; // made when the page is

    /** Trace on at the maps of tilted views that are in sight, the coarsest first, frame by frame. */
    let isTracing = false;
    function traceOn() {
        if (isTracing) return;
        isTracing = true;
        requestAnimationFrame(function step() {
            const waiting = cards.filter((card) => card.isInSight && !card.map.isDone);
            isTracing = waiting.length > 0;
            if (!isTracing) return;
            const card = waiting.reduce((a, b) => (b.map.stride > a.map.stride ? b : a));
            card.map.trace(performance.now() + TRACING_TIME);
            card.mapView.draw();
            requestAnimationFrame(step);
        });
    }

    /** Choose a point, in one of the stones. */
    function choose(point, card) {
        choices.set({ point, stone: card.place });
    }

    /** Show what was chosen: the tilt, and the ray at the same point of every stone. */
    function showChosen(changed) {
        if (!('turn' in changed || 'point' in changed)) return;
        if ('turn' in changed) cards.forEach((card) => card.setTurn());
        for (const card of cards) card.choose(choices.point);
        traceOn();
        announce(
            cards
                .map((card) => `${cards.length > 1 ? `${card.stone.name}: ` : ''}${number(card.path.intensity, 1)} %. ${card.sentence}`)
                .join(' '),
        );
    }

    /** A ray to begin with: bright, and reflected a few times. */
    function firstPoint() {
        const candidates = [];
        for (const radius of [0.34, 0.42, 0.28, 0.62, 0.5])
            for (const azimuth of [201, 219, 246, 264, 21, 39]) {
                const turn = (azimuth * Math.PI) / 180;
                candidates.push({ x: radius * Math.cos(turn), y: radius * Math.sin(turn) });
            }
        const isGood = (point) => {
            const path = cards[0].trace(point, cards[0].stone.view.basis);
            return path.intensity > 55 && path.reflections === 2;
        };
        return candidates.find(isGood) ?? candidates[0];
    }

    /** Properties in rows and stones in columns; of many stones, the other way round. */
    function table(root, heads, rows) {
        if (heads.length - 1 > MOST_COLUMNS) {
            const [, ...names] = heads;
            heads = ['', ...rows.map(({ cells: [name] }) => name)];
            rows = names.map((name, i) => ({ cells: [name, ...rows.map(({ cells }) => cells[i + 1])] }));
        }
        const head = element('tr', {}, ...heads.map((text) => element('th', { scope: 'col' }, text)));
        const body = rows.map(({ cells: [name, ...values], swatch, strong }) => {
            const mark = element('span', { className: 'swatch' });
            if (swatch) mark.style.background = swatch;
            const th = element('th', { scope: 'row' }, ...(swatch ? [mark] : []), name);
            const row = element('tr', {}, th, ...values.map((value) => element('td', {}, value)));
            if (strong) row.className = 'strong';
            return row;
        });
        root.replaceChildren(element('thead', {}, head), element('tbody', {}, ...body));
    }

    function fillTables() {
        const { stones } = data;
        const names = stones.length > 1 ? stones.map((stone) => stone.name) : [''];
        const ofEach = (value) => stones.map((stone) => value(stone));
        find(document, '.tables').classList.toggle('many', stones.length > MOST_COLUMNS);
        find(document, '.reading').classList.toggle('wide', stones.length > 1);

        const proportions = document.getElementById('proportions');
        // Of stones of different cuts all that any of them has.
        const rowNames = [...new Set(stones.flatMap((stone) => stone.proportions.map(({ name }) => name)))];
        const proportion = (stone, wanted) => {
            const found = stone.proportions.find(({ name }) => name === wanted);
            return found ? number(found.value, 2) + (found.unit === '%' ? ' %' : found.unit) : '–';
        };
        const rows = rowNames.map((name) => ({ cells: [name, ...ofEach((stone) => proportion(stone, name))] }));
        rows.push(
            { cells: ['Material', ...ofEach(({ material, model }) => material ?? (model.index === 2.4173 ? 'diamond' : '–'))] },
            { cells: ['Refractive index', ...ofEach(({ model }) => number(model.index, 4))] },
            { cells: ['Critical angle', ...ofEach(({ criticalAngle }) => `${number(criticalAngle, 2)}°`)] },
        );
        table(find(proportions, 'table'), ['', ...names], rows);
        find(proportions, 'thead').hidden = stones.length === 1;
        const measured = stones.filter((stone) => stone.measured).map((stone) => stone.name);
        find(proportions, '.note').textContent =
            [...new Set(stones.map((stone) => stone.proportionsText))].join(' ') +
            (measured.length ? ` Means over the vertices: ${measured.join(', ')}.` : '');
    }

    /** The table on top as paper has it: one for each measure, with its definition. */
    function fillPaper() {
        const names = data.stones.map((stone) => stone.name);
        const upright = values.turns.indexOf(0);
        const ofEach = (text) => names.map((_, stone) => text(stone));
        const parts = values.groups.map((group, i) => {
            const rows = values.columns.filter((column) => column.group === i).map((column) => ({
                cells: [column.label, ...ofEach((stone) => {
                    const value = values.value(stone, upright, column.key);
                    return value === null ? '–' : number(value, column.decimals);
                })],
                swatch: column.band !== null ? colours.bands[column.band] : column.key === 'rear' ? colours.rear : null,
                strong: i === 0 && column.band === null,
            }));
            const bounds = ofEach((stone) => values.bounds[stone][upright][i]);
            if (bounds.some((bound) => bound !== null))
                rows.push({ cells: ['Each within', ...bounds.map((bound) => (bound === null ? '–' : `±${boundText(bound)}`))] });
            const made = element('table');
            table(made, ['', ...names], rows);
            const note = element('p', { className: 'note' }, `${GemScores.typeset(group.definition)}. Source: ${group.source}.`);
            return element('div', {}, element('h2', {}, i === 0 ? 'Scores' : group.name), made, ...(i === 0 ? [] : [note]));
        });
        document.getElementById('comparison').append(...parts);
    }

    /** The table on top and the tilts, unless the only stone's own scores are all there is. */
    function fillTop() {
        const top = document.getElementById('scores');
        const isAlone = data.stones.length === 1 && values.groups.length === 1;
        top.hidden = isAlone && values.turns.length === 1;
        document.getElementById('comparison').hidden = isAlone;
        if (!isAlone) fillPaper();
        scoreTable = new GemScores.ScoreTable(top, {
            values, choices, colours, show: (stone) => showStone(stone),
            point: (band) => lights.point(band === 'rear' ? REAR : band),
        });
        new GemScores.Tilts(find(top, '.tilt'), document.getElementById('curve'), { values, choices, tip });
        new ResizeObserver(() => {
            document.documentElement.style.setProperty('--top', `${top.offsetHeight}px`);
        }).observe(top);
    }

    /** Bring a stone into sight. */
    function showStone(stone) {
        choices.set({ stone });
        cards[stone].root.scrollIntoView({ block: 'start' });
    }

    /** Take over what the link says. */
    function followLink() {
        choices.read();
        choices.point ??= firstPoint();
        for (const hear of choices.hear) hear(choices);
        if (choices.stone > 0) cards[choices.stone].root.scrollIntoView({ block: 'start' });
    }

    function fillHeading() {
        const { stones } = data;
        document.getElementById('title').textContent =
            stones.length === 1 ? stones[0].name : `${stones.length} stones compared`;
        const unique = (values) => [...new Set(values)].join('; ');
        const text = unique(stones.map((stone) => stone.modelText));
        document.getElementById('rules').textContent = `${text[0].toUpperCase()}${text.slice(1)}.`;
        document.getElementById('units').textContent = [
            `Lengths are in ${unique(stones.map((stone) => stone.unit))}.`,
            ...new Set(stones.map((stone) => REAR_WORDS[stone.model.rear])),
        ].join(' ');
        const engines = unique(stones.map((stone) => stone.engineText));
        document.getElementById('generator').textContent =
            `${data.generator}. Map: ${engines}. The ray${values.turns.length > 1 ? ', and the map of tilted stones,' : ''} is traced in this page, in double precision. ` +
            'The stone is drawn by three.js (MIT licence).';
    }

    function listenToPage() {
        const root = document.documentElement;
        const button = document.getElementById('theme');
        const system = matchMedia('(prefers-color-scheme: dark)');
        const setTheme = (isDark) => {
            root.dataset.theme = isDark ? 'dark' : 'light';
            button.setAttribute('aria-pressed', String(isDark));
        };
        setTheme(root.dataset.theme === 'dark');
        system.addEventListener('change', (event) => setTheme(event.matches));
        button.addEventListener('click', () => setTheme(root.dataset.theme !== 'dark'));
        document.getElementById('print').addEventListener('click', () => window.print());
        document.addEventListener('scroll', () => tip.hide(), { passive: true });
        PAPER.addEventListener('change', () => cards.forEach((card) => card.draw()));
        window.addEventListener('beforeprint', () => {
            for (const card of cards) {
                if (!card.map.isDone) card.map.trace(Infinity);
                card.draw();
            }
        });
    }

    async function start() {
        listenToPage();
        fillHeading();
        fillTables();
        fillTop();
        const parent = document.getElementById('stones');
        for (const card of cards) await card.build(parent);
        choices.hear.push(showChosen);
        followLink();
        window.addEventListener('hashchange', followLink);
        requestAnimationFrame(() => requestAnimationFrame(() => {
            document.documentElement.dataset.ready = 'true';
        }));
    }

    start().catch((error) => {
        const text = `This browser cannot draw the page (${error.message}); a newer one can.`;
        document.getElementById('stones').replaceChildren(element('p', { className: 'notice' }, text));
        throw error;
    });
})();
