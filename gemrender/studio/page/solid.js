// The stone in 3D, and the ray through the chosen point: traced here, in double precision, as the report does.

import { Light, Ray, Stage, Tracer, announce, cards, data, find, geometryOf, inNextFrame, number } from './shared.js';

/**
 * The map comes first: while the hand moves the 3D stone follows a little later, and where drawing it takes long only
 * once the hand rests [ms].
 */
const [SOON, AT_REST, LONG] = [30, 300, 12];

export class Solid {
    constructor(stageRoot, rayRoot, map) {
        Object.assign(this, { stageRoot, rayRoot, map });
        this.redrawStage = inNextFrame(() => this.draw());
        this.path = null;
        this.point = null;
        this.stage = null;
        this.shown = () => {};
        this.cost = 0;
        cards.push(this);
    }

    setFrame(frame) {
        const { planes, planeFacet, vertices, faces, faceFacet } = frame.arrays;
        const rows = (array, n) => Array.from({ length: array.length / n }, (_, i) => Array.from(array.subarray(n * i, n * i + n)));
        this.stone = {
            name: frame.name,
            facetNames: frame.facetNames,
            wall: frame.wall,
            round: frame.round,
            model: frame.model,
            solid: { planes: rows(planes, 4), planeFacet: Array.from(planeFacet), round: frame.round, mesh: null },
            mesh: { vertices: rows(vertices, 3), faces: rows(faces, 3), facets: Array.from(faceFacet) },
        };
        this.view = frame.view;
        this.surfaces = Tracer.surfacesOf(this.stone.solid);
        clearTimeout(this.coming);
        this.trace();
        if (this.stage) this.coming = setTimeout(() => this.update(), this.cost > LONG ? AT_REST : SOON);
        else this.update();
    }

    update() {
        this.geometry = this.map.geometry = geometryOf(this.stone);
        if (this.stage) this.stage.fill();
        else this.stage = new Stage(this.stageRoot, this);
        if (this.path) this.stage.setPath(this.path);
        this.fillRay();
        this.redrawStage();
        if (this.map.withLines) this.map.redraw();
        this.shown();
    }

    trace() {
        this.path = this.point
            ? Tracer.trace(this.surfaces, data.optics, { basis: this.view.basis }, this.stone.model, this.point.x, this.point.y)
            : null;
        this.map.path = this.path;
        this.map.point = this.point;
    }

    /** Show the ray through a point of the view. */
    choose(point) {
        this.point = point;
        if (!this.stone) return;
        this.trace();
        this.stage?.setPath(this.path);
        this.fillRay();
        this.redrawStage();
        this.map.redraw();
        announce(`${number(this.path.intensity, 1)} %. ${Ray.sentence(this.path, this.stone.facetNames)}`);
    }

    fillRay() {
        const { rayRoot: root, path, stone } = this;
        root.hidden = !path;
        if (!path) return;
        const isMissed = path.status === Tracer.STATUS.MISSED;
        find(root, '.swatch').style.background = isMissed ? 'transparent' : Light.pathColour(path);
        find(root, '.intensity b').textContent = isMissed ? '–' : `${number(path.intensity, 2)} %`;
        find(root, '.sentence').textContent = Ray.sentence(path, stone.facetNames);
        find(root, '.product').replaceChildren(...Ray.product(path, stone.model));
        find(root, '.path').hidden = isMissed;
        find(root, 'tbody').replaceChildren(...Ray.pathRows(path, stone.facetNames));
    }

    draw() {
        const start = performance.now();
        this.stage?.draw();
        this.cost = performance.now() - start;
    }
}
