'use strict';

// What the page tells in numbers of all stones together: the table on top with its definitions, the curves over
// tilt, and the link that keeps what was chosen. `page.js` puts them to work; all data is the page's.

const GemDom = (() => {
    const number = (value, digits) => value.toFixed(digits).replace('-', '−');
    const find = (root, selector) => root.querySelector(selector);

    function element(name, properties = {}, ...children) {
        const made = Object.assign(document.createElement(name), properties);
        made.append(...children);
        return made;
    }

    function drawing(name, attributes = {}, ...children) {
        const made = document.createElementNS('http://www.w3.org/2000/svg', name);
        for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
        made.append(...children);
        return made;
    }

    return Object.freeze({ number, find, element, drawing });
})();

const GemScores = (() => {
    const { number, find, element, drawing } = GemDom;
    /** Smallest bound that is told, as the command line does. */
    const LEAST_BOUND = 1e-4;

    /** A bound with two digits, rounded up, so that what is stated is true. */
    function boundText(bound) {
        const least = Math.max(bound, LEAST_BOUND);
        const decimals = 1 - Math.floor(Math.log10(least));
        const step = 10 ** -decimals;
        const text = (Math.ceil((least / step) * (1 - 1e-12)) * step).toFixed(Math.max(decimals, 0));
        return text.includes('.') ? text.replace(/\.?0+$/, '') : text;
    }

    const signed = (value, digits) => (value > 0 ? '+' : '') + number(value, digits);

    /** What is chosen: the same for the whole page, kept in its link. */
    class Choices {
        constructor({ stones, table }) {
            this.keys = ['name', ...table.columns.map(({ key }) => key)];
            this.turns = table.turns;
            this.stones = stones.length;
            this.hear = [];
            this.clear();
        }

        clear() {
            Object.assign(this, {
                stone: 0, point: null, sort: null, isDown: false, baseline: null,
                turn: this.turns.indexOf(0), curve: null,
            });
        }

        /** Change some of them, and tell who listens. */
        set(changed) {
            Object.assign(this, changed);
            for (const hear of this.hear) hear(changed);
            this.write();
        }

        /** Read the link; what makes no sense there is left out. */
        read() {
            const told = new URLSearchParams(location.hash.slice(1));
            const oneOf = (name) => {
                const value = Number(told.get(name));
                return Number.isInteger(value) && value >= 1 && value <= this.stones ? value - 1 : null;
            };
            const [x, y] = ['x', 'y'].map((name) => parseFloat(told.get(name) ?? ''));
            const sort = told.get('sort') ?? '';
            const column = sort.replace(/^-/, '');
            const turn = this.turns.indexOf(parseFloat(told.get('tilt') ?? '0'));
            const curve = told.get('curve');
            this.clear();
            this.stone = oneOf('stone') ?? 0;
            this.baseline = oneOf('baseline');
            if (Number.isFinite(x) && Number.isFinite(y)) this.point = { x, y };
            if (this.keys.includes(column)) [this.sort, this.isDown] = [column, sort !== column];
            if (turn >= 0) this.turn = turn;
            if (curve !== 'name' && this.keys.includes(curve)) this.curve = curve;
        }

        write() {
            const told = new URLSearchParams();
            if (this.stones > 1) told.set('stone', this.stone + 1);
            if (this.point) for (const axis of ['x', 'y']) told.set(axis, Number(this.point[axis].toFixed(5)));
            if (this.sort) told.set('sort', (this.isDown ? '-' : '') + this.sort);
            if (this.baseline !== null) told.set('baseline', this.baseline + 1);
            if (this.turns[this.turn] !== 0) told.set('tilt', this.turns[this.turn]);
            if (this.curve) told.set('curve', this.curve);
            try {
                history.replaceState(null, '', `#${told}`);
            } catch {
                // A browser that allows few changes in a while, or none here: the page goes on without.
            }
        }
    }

    /** Values of the table, by stone and turn. */
    class Values {
        constructor({ stones, table }) {
            Object.assign(this, { ...table, names: stones.map(({ name }) => name) });
            this.places = new Map(table.columns.map(({ key }, i) => [key, i]));
        }

        value(stone, turn, key) {
            return this.values[stone][turn][this.places.get(key)] ?? null;
        }

        bound(stone, turn, key) {
            return this.bounds[stone][turn][this.columns[this.places.get(key)].group];
        }

        /** A column's name where it stands alone: "Average", "iso", "aset green". */
        title({ key, label, group }) {
            const { name } = this.groups[group];
            return group === 0 ? label : key === name ? name : `${name} ${label}`;
        }

        unit({ group, decimals }) {
            const { unit } = this.groups[group];
            return decimals === 0 ? '' : unit;
        }
    }

    /** The table on top: a row a stone, sorted by any column; against a baseline, the differences from it. */
    class ScoreTable {
        constructor(root, { values, choices, colours, point, show }) {
            Object.assign(this, { root, values, choices, colours, point, show });
            this.body = element('tbody');
            this.heads = new Map();
            find(root, 'table').append(this.head(), this.body);
            this.fillBaseline();
            find(root, '#csv').addEventListener('click', () => this.download());
            choices.hear.push((changed) => ['sort', 'isDown', 'baseline', 'turn'].some((key) => key in changed) && this.fill());
            this.fill();
        }

        head() {
            const { groups, columns } = this.values;
            const runs = []; // columns of one measure that stand side by side
            for (const { group } of columns)
                if (runs.at(-1)?.group === group) runs.at(-1).length += 1;
                else runs.push({ group, length: 1 });
            const upper = runs.map(({ group, length }) => {
                const { name } = groups[group];
                const button = element('button', { type: 'button', className: 'define' }, name);
                button.setAttribute('aria-haspopup', 'dialog');
                button.title = `Definition and source of ${name}`;
                button.addEventListener('click', () => define(groups[group]));
                return element('th', { scope: 'colgroup', colSpan: length, className: 'first' }, button);
            });
            const lower = columns.map((column, i) => {
                const isFirst = i === 0 || columns[i - 1].group !== column.group;
                return this.sorter(column.key, column.label, column, isFirst ? 'first' : '');
            });
            const name = this.sorter('name', 'Stone', {}, '');
            name.rowSpan = 2;
            return element('thead', {}, element('tr', {}, name, ...upper), element('tr', {}, ...lower));
        }

        sorter(key, label, { band }, className) {
            const button = element('button', { type: 'button' }, ...this.swatch(key, band), label);
            const head = element('th', { scope: 'col', className }, button);
            button.addEventListener('click', () => {
                // First the way that tells most: names from A, numbers from the largest; then the other; then none.
                const { sort, isDown } = this.choices;
                const first = key !== 'name';
                if (sort !== key) this.choices.set({ sort: key, isDown: first });
                else if (isDown === first) this.choices.set({ isDown: !first });
                else this.choices.set({ sort: null, isDown: false });
            });
            this.listen(head, key, band);
            this.heads.set(key, head);
            return head;
        }

        swatch(key, band) {
            const colour = band != null ? this.colours.bands[band] : key === 'rear' ? this.colours.rear : null;
            if (colour === null) return [];
            const mark = element('span', { className: 'swatch' });
            mark.style.background = colour;
            return [mark];
        }

        /** What is pointed at here lights up in the maps. */
        listen(cell, key, band) {
            const pointed = band ?? (key === 'rear' ? 'rear' : null);
            if (pointed === null) return;
            cell.dataset.band = pointed;
            cell.addEventListener('pointerenter', () => this.point(pointed));
            cell.addEventListener('pointerleave', () => this.point(null));
        }

        fillBaseline() {
            const { names } = this.values;
            const box = find(this.root, '#baseline');
            box.closest('label').hidden = names.length === 1;
            box.append(element('option', { value: '' }, 'none'));
            names.forEach((name, i) => box.append(element('option', { value: i }, name)));
            box.addEventListener('change', () =>
                this.choices.set({ baseline: box.value === '' ? null : Number(box.value) }),
            );
            this.box = box;
        }

        /** Numbers of the stones, in the table's order: without a value last. */
        order() {
            const { sort, isDown, turn } = this.choices;
            const stones = [...this.values.names.keys()];
            if (sort === null) return stones;
            const keyOf = (i) => (sort === 'name' ? this.values.names[i] : this.values.value(i, turn, sort));
            const compare = sort === 'name' ? (a, b) => a.localeCompare(b, 'en') : (a, b) => a - b;
            return stones.sort((i, j) => {
                const [a, b] = [keyOf(i), keyOf(j)];
                if (a === null || b === null) return (a === null) - (b === null);
                return isDown ? compare(b, a) : compare(a, b);
            });
        }

        fill() {
            const { sort, isDown, baseline } = this.choices;
            this.box.value = baseline ?? '';
            for (const [key, head] of this.heads) {
                if (key === sort) head.setAttribute('aria-sort', isDown ? 'descending' : 'ascending');
                else head.removeAttribute('aria-sort');
            }
            this.body.replaceChildren(...this.order().map((stone) => this.row(stone)));
        }

        row(stone) {
            const { names, columns } = this.values;
            const button = element('button', { type: 'button' }, names[stone]);
            button.addEventListener('click', () => this.show(stone));
            const row = element('tr', {}, element('th', { scope: 'row' }, button));
            row.dataset.stone = stone;
            const { baseline } = this.choices;
            if (baseline === stone) row.className = 'baseline';
            columns.forEach((column, i) => {
                const isDifference = baseline !== null && baseline !== stone;
                const cell = isDifference ? this.difference(stone, column) : this.cell(stone, column);
                if (i === 0 || columns[i - 1].group !== column.group) cell.classList.add('first');
                this.listen(cell, column.key, column.band);
                row.append(cell);
            });
            return row;
        }

        cell(stone, { key, decimals }) {
            const { turn } = this.choices;
            const value = this.values.value(stone, turn, key);
            if (value === null) return element('td', {}, '–');
            return element('td', {}, number(value, decimals), ...bounded(this.values.bound(stone, turn, key), decimals));
        }

        difference(stone, { key, decimals }) {
            const { turn, baseline } = this.choices;
            const [value, from] = [stone, baseline].map((i) => this.values.value(i, turn, key));
            if (value === null || from === null) return element('td', {}, '–');
            const bounds = [stone, baseline].map((i) => this.values.bound(i, turn, key));
            const bound = bounds.includes(null) || decimals === 0 ? null : bounds[0] + bounds[1];
            const cell = element('td', {}, signed(value - from, decimals), ...bounded(bound, decimals));
            // Stones may be alike in it, for all that is known.
            if (bound !== null && Math.abs(value - from) <= bound) cell.className = 'within';
            return cell;
        }

        /** Mark in a stone's row the band that is pointed at in its map; null for none. */
        mark(stone, band) {
            for (const cell of this.body.querySelectorAll('td.lit')) cell.classList.remove('lit');
            const row = find(this.body, `tr[data-stone="${stone}"]`);
            if (band !== null) row?.querySelector(`td[data-band="${band}"]`)?.classList.add('lit');
        }

        /** The table as the command line's CSV has it, every digit, with all turns of each stone. */
        download() {
            const { head, rows } = this.values.csv;
            const lines = [head, ...this.order().flatMap((stone) => rows[stone])];
            const file = new Blob([lines.map((line) => `${line}\r\n`).join('')], { type: 'text/csv' });
            const address = URL.createObjectURL(file);
            element('a', { href: address, download: 'gemrender-scores.csv' }).click();
            setTimeout(() => URL.revokeObjectURL(address), 1000);
        }
    }

    function bounded(bound, decimals) {
        return bound === null || decimals === 0 ? [] : [' ', element('small', {}, `±${boundText(bound)}`)];
    }

    /** A definition as print has it. */
    const typeset = (text) => text[0].toUpperCase() + text.slice(1).replace(/`([^`]*)`/g, '“$1”').replaceAll(' - ', ' − ');

    function define(group) {
        const dialog = document.getElementById('definition');
        find(dialog, 'h2').textContent = group.name;
        find(dialog, '.words').textContent = `${typeset(group.definition)}.`;
        find(dialog, '.source').textContent = `Source: ${group.source}. Version ${group.version}.`;
        dialog.showModal();
    }

    // ---- Tilt ------------------------------------------------------------------------------------------

    /** Lines of stones: so many colours, then the same ones dashed. */
    const LINES = ['#2f7ed8', '#d0661a', '#2a9660', '#b8417a', '#7d64c8', '#8c7a20'];
    const DASHES = ['', '7 4', '2 4', '10 3 2 3'];
    const HEIGHT = 160;
    const EDGES = { left: 46, right: 14, top: 12, bottom: 26 };

    /** Round numbers that divide a range into few parts. */
    function ticks(low, high, most) {
        const rough = (high - low) / most;
        const power = 10 ** Math.floor(Math.log10(rough));
        const step = [1, 2, 5, 10].find((factor) => factor * power >= rough) * power;
        const out = [];
        for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push(k * step);
        return { step, out };
    }

    /** The slider over the tilts, and the curve of a value over them. */
    class Tilts {
        constructor(slider, root, { values, choices, tip }) {
            Object.assign(this, { root, values, choices, tip });
            this.slider = find(slider, 'input');
            this.output = find(slider, 'output');
            this.svg = find(root, 'svg');
            this.box = find(root, 'select');
            slider.hidden = root.hidden = values.turns.length === 1;
            if (root.hidden) return;
            find(slider, '.axis').textContent = `Tilt about ${values.axis}`;
            Object.assign(this.slider, { min: 0, max: values.turns.length - 1, step: 1 });
            this.slider.addEventListener('input', () => choices.set({ turn: Number(this.slider.value) }));
            this.fillBox();
            this.fillLegend();
            this.listen();
            choices.hear.push((changed) => ['turn', 'curve'].some((key) => key in changed) && this.draw());
            new ResizeObserver(() => this.draw()).observe(this.svg.parentElement);
            this.draw();
        }

        fillBox() {
            const { groups, columns } = this.values;
            groups.forEach(({ name }, i) => {
                const options = columns
                    .filter(({ group }) => group === i)
                    .map((column) => element('option', { value: column.key }, this.values.title(column)));
                this.box.append(element('optgroup', { label: name }, ...options));
            });
            this.box.addEventListener('change', () => this.choices.set({ curve: this.box.value }));
        }

        /** The column that is drawn: what was chosen, else the first of the measures that were asked for. */
        get column() {
            const { columns } = this.values;
            const asked = columns.find(({ group }) => group > 0) ?? columns[0];
            return columns.find(({ key }) => key === this.choices.curve) ?? asked;
        }

        fillLegend() {
            const { names } = this.values;
            const legend = find(this.root, '.legend');
            legend.hidden = names.length === 1;
            names.forEach((name, i) => {
                const mark = drawing('svg', { class: 'mark', width: 26, height: 10, 'aria-hidden': 'true' },
                    drawing('line', { x1: 1, x2: 25, y1: 5, y2: 5, ...lineStyle(i) }));
                const item = element('li', {}, mark, name);
                item.addEventListener('pointerenter', () => this.light(i));
                item.addEventListener('pointerleave', () => this.light(null));
                legend.append(item);
            });
        }

        /** Bring out the line of one stone. */
        light(stone) {
            for (const line of this.svg.querySelectorAll('[data-stone]'))
                line.classList.toggle('faded', stone !== null && Number(line.dataset.stone) !== stone);
        }

        angleText(turn) {
            return `${number(this.values.turns[turn], 2).replace(/\.?0+$/, '')}°`;
        }

        draw() {
            const { turns, names } = this.values;
            const { turn } = this.choices;
            const { column } = this;
            this.slider.value = turn;
            this.output.textContent = this.angleText(turn);
            this.slider.setAttribute('aria-valuetext', `${this.angleText(turn)} about ${this.values.axis}`);
            this.box.value = column.key;
            const width = Math.max(this.svg.parentElement.clientWidth, 200);
            const curves = names.map((_, stone) =>
                turns
                    .map((angle, i) => ({
                        angle,
                        value: this.values.value(stone, i, column.key),
                        bound: (column.decimals && this.values.bound(stone, i, column.key)) || 0,
                    }))
                    .filter(({ value }) => value !== null),
            );
            const all = curves.flat();
            const lows = all.map(({ value, bound }) => value - bound);
            const highs = all.map(({ value, bound }) => value + bound);
            let [low, high] = all.length ? [Math.min(...lows), Math.max(...highs)] : [0, 1];
            const least = column.decimals === 3 ? 0.01 : 1; // a level line is drawn level
            if (high - low < least) [low, high] = [(low + high - least) / 2, (low + high + least) / 2];
            const room = 0.06 * (high - low);
            [low, high] = [low - room, high + room];
            const { left, right, top, bottom } = EDGES;
            const [first, last] = [turns[0], turns.at(-1)];
            const x = (angle) => left + ((angle - first) / (last - first)) * (width - left - right);
            const y = (value) => HEIGHT - bottom - ((value - low) / (high - low)) * (HEIGHT - top - bottom);
            this.angleAt = (u) => first + ((u - left) / (width - left - right)) * (last - first);
            const drawn = [];
            const { step, out } = ticks(low, high, 4);
            const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
            for (const value of out)
                drawn.push(
                    drawing('line', { class: 'grid', x1: left, x2: width - right, y1: y(value), y2: y(value) }),
                    drawing('text', { x: left - 6, y: y(value) + 4, 'text-anchor': 'end' }, number(value, digits)),
                );
            for (const angle of ticks(first, last, width < 500 ? 5 : 10).out)
                drawn.push(
                    drawing('text', { x: x(angle), y: HEIGHT - 8, 'text-anchor': 'middle' }, `${number(angle, 0)}°`),
                );
            drawn.push(drawing('line', { class: 'cursor', x1: x(turns[turn]), x2: x(turns[turn]), y1: top, y2: HEIGHT - bottom }));
            curves.forEach((curve, stone) => {
                if (!curve.length) return;
                const [above, below] = [1, -1].map((sign) =>
                    curve.map(({ angle, value, bound }) => `${x(angle).toFixed(1)},${y(value + sign * bound).toFixed(1)}`),
                );
                const points = curve.map(({ angle, value }) => `${x(angle).toFixed(1)},${y(value).toFixed(1)}`);
                const style = lineStyle(stone);
                const parts = [
                    drawing('polygon', { fill: style.stroke, 'fill-opacity': 0.22, points: [...above, ...below.reverse()].join(' ') }),
                    drawing('polyline', { fill: 'none', ...style, points: points.join(' ') }),
                ];
                const here = curve.find(({ angle }) => angle === turns[turn]);
                if (here) parts.push(drawing('circle', { cx: x(here.angle), cy: y(here.value), r: 4.5, fill: style.stroke }));
                drawn.push(drawing('g', { 'data-stone': stone }, ...parts));
            });
            Object.entries({ viewBox: `0 0 ${width} ${HEIGHT}`, width, height: HEIGHT }).forEach(([key, value]) =>
                this.svg.setAttribute(key, value),
            );
            this.svg.setAttribute('aria-label', `${this.values.title(column)} over tilt about ${this.values.axis}`);
            this.svg.replaceChildren(...drawn);
            find(this.root, '.now').textContent = this.words(turn);
        }

        /** The values at a turn, in words. */
        words(turn) {
            const { column } = this;
            const unit = this.values.unit(column) && ` ${this.values.unit(column)}`;
            const each = this.values.names.map((name, stone) => {
                const value = this.values.value(stone, turn, column.key);
                const bound = column.decimals ? this.values.bound(stone, turn, column.key) : null;
                const said = value === null ? '–' : number(value, column.decimals) + (bound === null ? '' : ` ±${boundText(bound)}`) + unit;
                return this.values.names.length === 1 ? said : `${name} ${said}`;
            });
            return `${this.angleText(turn)}: ${each.join('; ')}`;
        }

        listen() {
            const nearest = (event) => {
                const box = this.svg.getBoundingClientRect();
                const angle = this.angleAt(event.clientX - box.left);
                const away = this.values.turns.map((turn) => Math.abs(turn - angle));
                return away.indexOf(Math.min(...away));
            };
            this.svg.addEventListener('pointerdown', (event) => {
                this.svg.setPointerCapture(event.pointerId);
                this.choices.set({ turn: nearest(event) });
            });
            this.svg.addEventListener('pointermove', (event) => {
                if (event.buttons) this.choices.set({ turn: nearest(event) });
                else if (event.pointerType !== 'touch') this.tip.show(event, this.words(nearest(event)));
            });
            this.svg.addEventListener('pointerleave', () => this.tip.hide());
        }
    }

    function lineStyle(stone) {
        return {
            stroke: LINES[stone % LINES.length],
            'stroke-width': 2,
            'stroke-dasharray': DASHES[Math.floor(stone / LINES.length) % DASHES.length],
        };
    }

    return Object.freeze({ Choices, Values, ScoreTable, Tilts, boundText, typeset });
})();
