'use strict';

// The stage: a stone in 3D with the ray through the chosen point, to be turned and clicked. Uses THREE
// (three.min.js).

const GemStage = (() => {
    const { STATUS, dot } = GemTracer;
    const { find, announce } = GemDom;
    const { cards, choose } = GemPage;
    const { MOST_NUMBERED, rayColour, rayWidth, lightLines, stationNames, fitted, beginLines, drawArrows } = GemLight;

    /** A press that moves less than this is a click [CSS px]. */
    const CLICK_SLACK = 5;
    const STAGE_FONT = '600 11px "Segoe UI", Roboto, Helvetica, Arial, sans-serif';
    const STAGE_GLOW = ['#1d2530', '#0b0e13'];
    /** Edges that look away from the eye, and those that look at it [CSS px]. */
    const FAR_EDGES = { colour: '#9fb6d3', opacity: 0.3, width: 1 };
    const NEAR_EDGES = { colour: '#dfe9f7', opacity: 0.9, width: 1.35 };

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
            // Asked for by itself: without WebGL, Three would write an error to the console
            const canvas = document.createElement('canvas');
            const context = canvas.getContext('webgl2', { antialias: true, alpha: true });
            if (context === null) return (shared = null);
            try {
                shared = new THREE.WebGLRenderer({ canvas, context, antialias: true, alpha: true });
                shared.autoClear = false;
                shared.setPixelRatio(1);
                shared.setClearColor(0x000000, 0); // which it else does only as it draws, after the first clearing
                shared.setSize(1, 1, false);
                shared.domElement.addEventListener('webglcontextrestored', () => cards.forEach((card) => card.redrawStage()));
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

    /** Distance of a place on a canvas from a line there. */
    function distanceTo([[ax, ay], [bx, by]], [x, y]) {
        const [dx, dy] = [bx - ax, by - ay];
        const share = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1);
        const nearest = Math.min(Math.max(share, 0), 1);
        return Math.hypot(ax + nearest * dx - x, ay + nearest * dy - y);
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
            this.fill();
            Object.assign(this, VIEWS.tilted, { zoom: 1 });
            this.listen(root);
        }

        build() {
            const geometry = (this.faces = new THREE.BufferGeometry());
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
            const lines = ({ colour, opacity, width }, depthTest) =>
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
            const depth = new THREE.MeshBasicMaterial({
                colorWrite: false,
                polygonOffset: true,
                polygonOffsetFactor: 1,
                polygonOffsetUnits: 4,
            });
            this.hidden = lines(FAR_EDGES, false);
            this.visible = lines(NEAR_EDGES, true);
            this.silhouette = lines(NEAR_EDGES, false);
            this.ray = lines({ colour: '#ffffff', opacity: 1, width: 2.6 }, true);
            this.met = facets(THREE.DoubleSide, 1);
            this.met.geometry = new THREE.BufferGeometry();
            this.met.material.uniforms.highlight = { value: 1 };
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
        }

        /** Take over the card's stone; again where it has changed. */
        fill() {
            const { positions, normals, outlines, wall } = this.card.geometry;
            this.wall = wall;
            this.faces.dispose();
            this.faces.setAttribute('position', new THREE.BufferAttribute(new Float32Array(positions), 3));
            this.faces.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(normals), 3));
            const outline = outlines.flatMap(({ from, to }) => [...from, ...to]);
            for (const drawn of [this.hidden, this.visible]) setLines(drawn, outline);
            const { vertices } = this.card.stone.mesh;
            const heights = vertices.map((v) => v[2]);
            const [bottom, top] = [Math.min(...heights), Math.max(...heights)];
            this.centre = [0, 0, (bottom + top) / 2 + RAISED];
            const reach = Math.max(...vertices.map(([x, y]) => Math.hypot(x, y)));
            this.extent = Math.max(reach + ASIDE, (top - bottom) / 2 + MARGIN);
        }

        show(name) {
            Object.assign(this, VIEWS[name], { zoom: 1 });
            this.card.redrawStage();
        }

        turn(azimuth, elevation) {
            this.azimuth += azimuth;
            this.elevation = Math.min(Math.max(this.elevation + elevation, -90), 90);
            this.card.redrawStage();
        }

        zoomBy(factor) {
            this.zoom = Math.min(Math.max(this.zoom * factor, ZOOMS[0]), ZOOMS[1]);
            this.card.redrawStage();
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
                if (renderer().domElement.width !== pixels) renderer().setSize(pixels, pixels, false);
                renderer().clear();
                renderer().render(this.scene, this.camera);
                context.drawImage(renderer().domElement, 0, 0, width, width);
            }
            const scale = width / (2 * half);
            const onCanvas = (p) => {
                const q = p.map((value, i) => value - this.centre[i]);
                return [width / 2 + scale * dot(q, right), width / 2 - scale * dot(q, up)];
            };
            const lines = isShown ? lightLines(path).map((ends) => ends.map(onCanvas)) : [];
            if (!renderer()) this.drawInLines(context, onCanvas, eye, lines);
            if (!isShown) return;

            if (lines.length <= MOST_NUMBERED + 2) drawArrows(context, lines, rayColour(path), 5.5);
            this.drawLabels(context, stationNames(path), path.points.map(onCanvas), lines, width);
        }

        /** Outline the girdle's wall where it turns away from the eye. */
        outlineWall(eye) {
            const ends = this.turning(eye).flatMap(({ from, to }) => [...from, ...to]);
            this.silhouette.visible = ends.length > 0;
            if (ends.length > 0) setLines(this.silhouette, ends);
        }

        /** The edges within the girdle's wall where it turns away from the eye. */
        turning(eye) {
            return this.wall.filter(({ normals: [one, other] }) => dot(one, eye) > 0 !== dot(other, eye) > 0);
        }

        /** Draw edges and the ray by themselves, where there is no WebGL: what is far first. */
        drawInLines(context, onCanvas, eye, ray) {
            const stroke = (ends, { colour, opacity, width }) => {
                context.strokeStyle = colour;
                context.globalAlpha = opacity;
                context.lineWidth = width;
                beginLines(context, ends);
                context.stroke();
                context.globalAlpha = 1;
            };
            const placed = (edges) => edges.map(({ from, to }) => [onCanvas(from), onCanvas(to)]);
            const { outlines } = this.card.geometry;
            const isNear = ({ normals }) => normals.some((normal) => dot(normal, eye) > 0);
            stroke(placed(outlines.filter((edge) => !isNear(edge))), FAR_EDGES);
            if (ray.length > 0)
                stroke(ray, { colour: rayColour(this.card.path), opacity: 1, width: rayWidth(this.card.path) });
            stroke(placed([...outlines.filter(isNear), ...this.turning(eye)]), NEAR_EDGES);
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

    return Object.freeze({ Stage });
})();
