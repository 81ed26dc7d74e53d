'use strict';

// The tilts: the slider over them, and the curves of a value over them.

const GemTilts = (() => {
    const { number, find, boundText, element, drawing, tip } = GemDom;

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
        constructor(slider, root, { values, choices }) {
            Object.assign(this, { root, values, choices });
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
                else if (event.pointerType !== 'touch') tip.show(event, this.words(nearest(event)));
            });
            this.svg.addEventListener('pointerleave', () => tip.hide());
        }
    }

    function lineStyle(stone) {
        return {
            stroke: LINES[stone % LINES.length],
            'stroke-width': 2,
            'stroke-dasharray': DASHES[Math.floor(stone / LINES.length) % DASHES.length],
        };
    }

    return Object.freeze({ Tilts });
})();
