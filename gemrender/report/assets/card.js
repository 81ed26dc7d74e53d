'use strict';

// The card of a stone: its stage and its map, its scores, and the ray through the chosen point.

const GemCard = (() => {
    const { STATUS, dot } = GemTracer;
    const { number, find, boundText, element, inNextFrame } = GemDom;
    const { data, choices, values, cards, traceOn, press, lights } = GemPage;
    const { codes } = data;
    const { REAR, UNSOLVED, kindOf, kindColour, kinds, pathColour, isFitted } = GemLight;
    const { sentence, product, difference, pathRows } = GemRay;
    const { ScoredMap, TracedMap, geometryOf } = GemStone;
    const { Stage } = GemStage;
    const { MapView } = GemMap;

    /** Time for the map of a tilted view before the first frame [ms]; so many finished ones are kept for all stones. */
    const FIRST_TIME = 30;
    const MOST_TRACED = 48;

    class Card {
        constructor(stone, place) {
            Object.assign(this, { stone, place, view: stone.view, isScored: true });
            this.map = this.scored = new ScoredMap(stone.map);
            this.traced = new Map();
            this.surfaces = GemTracer.surfacesOf(stone.solid);
            this.geometry = geometryOf(stone);
            this.path = null;
            this.pixel = null;
            this.isInSight = this.isMapStale = this.isStageStale = false;
            this.drawSoon = inNextFrame(() => this.drawStale());
            const made = document.getElementById('stone').content.cloneNode(true);
            this.root = find(made, 'article');
        }

        /** Make it part of the page; what is returned waits until it is known whether it is in sight. */
        build(parent) {
            const { root, stone } = this;
            root.setAttribute('aria-label', stone.name);
            find(root, '.name').textContent = stone.name;
            find(root, '.name').hidden = data.stones.length === 1;
            parent.append(root);
            this.stage = new Stage(find(root, '.stage'), this);
            this.mapView = new MapView(find(root, '.map'), this);
            this.fillScores();
            this.fillAlike();
            // It changes its height with every path's table, its drawings with their width alone.
            new ResizeObserver(() => {
                if (![this.stage, this.mapView].every(({ canvas }) => isFitted(canvas))) this.redraw();
            }).observe(root);
            return new Promise((resolve) => {
                new IntersectionObserver((entries) => {
                    this.isInSight = entries.at(-1).isIntersecting;
                    if (this.isInSight) this.drawSoon();
                    traceOn();
                    resolve();
                }, { rootMargin: '50%' }).observe(root);
            });
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
            GemPage.scoreTable.mark(this.place, kind === REAR ? 'rear' : kind >= 0 ? kind : null);
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

        /** Draw both in the next frame of the screen, or once they are in sight. */
        redraw() {
            this.redrawMap();
            this.redrawStage();
        }

        redrawMap() {
            this.isMapStale = true;
            if (this.isInSight) this.drawSoon();
        }

        redrawStage() {
            this.isStageStale = true;
            if (this.isInSight) this.drawSoon();
        }

        drawStale() {
            if (this.isMapStale) this.mapView?.draw();
            if (this.isStageStale) this.stage?.draw();
            this.isMapStale = this.isStageStale = false;
        }

        draw() {
            this.isMapStale = this.isStageStale = true;
            this.drawStale();
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

    function hoverable(row, enter, leave, click) {
        row.addEventListener('pointerenter', (event) => event.pointerType !== 'touch' && enter());
        row.addEventListener('pointerleave', leave);
        find(row, 'button').addEventListener('click', click);
    }

    function shareText(share) {
        const digits = share === 0 || share >= 0.05 ? 1 : 2 - Math.ceil(Math.log10(share));
        return `${number(share, digits)} %`;
    }

    return Object.freeze({ Card });
})();
