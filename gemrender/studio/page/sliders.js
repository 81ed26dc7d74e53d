// The sliders: a row for each number of the cut, and beside it what a small push does, and where the next cliff is.

import { element, number, signed } from './shared.js';

const SIGNS = { deg: '°', '%': '%', '': '' };
const DECIMALS = { deg: 2, '%': 2, '': 3 };
/** Changes by less are told as none [% of the light]. */
const LEAST = 0.005;

export class Sliders {
    /** `moved` is called with name, value, and words once the hand has come to rest. */
    constructor(root, moved) {
        Object.assign(this, { root, moved });
        this.rows = new Map();
    }

    /** Make the rows anew. */
    fill(sliders, values) {
        this.rows.clear();
        const groups = new Map();
        for (const slider of sliders) {
            if (!groups.has(slider.group)) groups.set(slider.group, []);
            groups.get(slider.group).push(slider.choices.length ? this.choice(slider) : this.row(slider));
        }
        const made = [...groups].flatMap(([name, rows]) => (name ? [element('h2', {}, name), ...rows] : rows));
        this.root.replaceChildren(...made);
        if (!sliders.length)
            this.root.append(element('p', { className: 'note' }, 'This stone was measured, not made from proportions: there is nothing to drag, and all else works.'));
        this.show(values);
    }

    row(slider) {
        const id = `slider-${slider.name.replace(/\W+/g, '-')}`;
        const range = element('input', { type: 'range', id, min: slider.low, max: slider.high, step: slider.step / 10 });
        const box = element('input', { type: 'number', min: slider.least, max: slider.most, step: slider.step });
        box.setAttribute('aria-label', `${slider.label} [${SIGNS[slider.unit] || 'ratio'}]`);
        const marks = element('span', { className: 'marks' });
        marks.setAttribute('aria-hidden', 'true');
        const push = element('p', { className: 'push' });
        const root = element('div', { className: 'slider' },
            element('label', { htmlFor: id }, slider.label),
            element('span', { className: 'value' }, box, element('span', { className: 'unit' }, SIGNS[slider.unit])),
            element('span', { className: 'track' }, range, marks),
            push,
        );
        const row = { slider, range, box, marks, push, root, cliffs: null };
        const text = (value) => `${slider.label} ${number(value, DECIMALS[slider.unit])}${SIGNS[slider.unit] === '°' ? '°' : slider.unit && ' %'}`;
        const take = (value, isAtRest) => {
            if (!Number.isFinite(value)) return;
            this.moved(slider.name, value, isAtRest ? text(value) : null);
        };
        range.addEventListener('input', () => take(this.rounded(slider, range.valueAsNumber), false));
        range.addEventListener('change', () => take(this.rounded(slider, range.valueAsNumber), true));
        range.addEventListener('keydown', (event) => {
            const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[event.key];
            if (!steps || event.ctrlKey || event.metaKey || event.altKey) return;
            event.preventDefault();
            const by = steps * slider.step * (event.shiftKey ? 10 : 1);
            range.value = Number(range.value) + by;
            take(this.rounded(slider, range.valueAsNumber), true);
        });
        box.addEventListener('change', () => take(box.valueAsNumber, true));
        this.rows.set(slider.name, row);
        return root;
    }

    /** A slider's own steps: not more digits than the hand can tell. */
    rounded({ step }, value) {
        const fine = step / 10;
        return Number((Math.round(value / fine) * fine).toFixed(6));
    }

    choice(slider) {
        const id = `slider-${slider.name}`;
        const box = element('select', { id }, ...slider.choices.map((value) => element('option', { value }, String(value))));
        box.addEventListener('change', () => {
            const value = slider.choices.find((of) => String(of) === box.value);
            this.moved(slider.name, value, `${slider.label} ${value}`);
        });
        this.rows.set(slider.name, { slider, box, isChoice: true });
        return element('div', { className: 'slider choice' }, element('label', { htmlFor: id }, slider.label), box);
    }

    valueOf(values, name) {
        const [key, place] = name.split(/\.(?=\d+$)/);
        return place === undefined ? values[key] : values[key]?.[Number(place)];
    }

    /** Show values; the row that is typed in is left alone. */
    show(values, baseline = null) {
        for (const [name, row] of this.rows) {
            const value = this.valueOf(values, name);
            if (value === undefined) continue;
            if (row.isChoice) {
                row.box.value = String(value);
                continue;
            }
            if (value < Number(row.range.min)) row.range.min = value;
            if (value > Number(row.range.max)) row.range.max = value;
            if (Number(row.range.value) !== value) row.range.value = value;
            if (document.activeElement !== row.box || row.shown !== value)
                row.box.value = Number(value.toFixed(DECIMALS[row.slider.unit]));
            const before = baseline && this.valueOf(baseline, name);
            const marked = typeof before === 'number' ? before : null;
            if (row.shown === value && row.before === marked) continue; // a design has many, and few move
            row.shown = value;
            row.before = marked;
            row.range.setAttribute('aria-valuetext', `${number(value, DECIMALS[row.slider.unit])} ${{ deg: 'degrees', '%': 'per cent', '': '' }[row.slider.unit]}`);
            this.mark(row);
        }
    }

    /** What was found out holds no more. */
    fade() {
        this.root.classList.add('stale');
    }

    /** What a unit of each does to Average and Rear. */
    setSlopes(slopes) {
        this.root.classList.remove('stale');
        const of = (name) => slopes[name] ?? slopes[name.replace('.', '_')];
        const rows = [...this.rows].filter(([, row]) => !row.isChoice).map(([name, row]) => [of(name), row]);
        const largest = Math.max(...rows.map(([slope, { slider }]) => Math.abs(pushOf(slider) * (slope?.average ?? 0))), 1e-9);
        for (const [slope, row] of rows) {
            row.push.replaceChildren(...(slope ? pushed(slope, row.slider, largest) : []));
        }
    }

    clearCliffs() {
        for (const row of this.rows.values()) {
            if (row.isChoice || !row.cliffs) continue;
            row.cliffs = null;
            this.mark(row);
        }
    }

    setCliffs(parameter, sides) {
        const row = this.rows.get(parameter);
        if (!row || row.isChoice) return;
        row.cliffs = sides;
        this.mark(row);
    }

    mark({ range, marks, cliffs, before, slider, root }) {
        const [low, high] = [Number(range.min), Number(range.max)];
        const at = (value) => `${(100 * (value - low)) / (high - low)}%`;
        const made = [];
        if (before !== null && before !== undefined && before >= low && before <= high) {
            const mark = element('i', { className: 'baseline', title: `Baseline ${number(before, DECIMALS[slider.unit])}` });
            mark.style.left = at(before);
            made.push(mark);
        }
        const told = [];
        for (const { at: place, what, jump } of Object.values(cliffs ?? {})) {
            if (place === null || place < low || place > high) continue;
            const words = `Cliff at ${number(place, 2)}${SIGNS[slider.unit]}: ${cliffWords(what)} jumps by ${signed(jump, 1)}`;
            told.push(words);
            const mark = element('i', { className: 'cliff', title: words });
            mark.style.left = at(place);
            made.push(mark);
        }
        marks.replaceChildren(...made);
        root.title = told.join('\n');
    }
}

const cliffWords = (what) => (what ?? '').replace(/^inoue /, '').replace(/^./, (letter) => letter.toUpperCase());

/** A small push: one degree or per cent, of ratios and distances less. */
const pushOf = ({ unit, step }) => (unit ? 1 : step < 0.005 ? 0.01 : 0.1);

/** What one unit more does, as an arrow and a number for Average and for Rear. */
function pushed({ average, averageBound, rear, rearBound }, { unit, label, step }, largest) {
    const by = pushOf({ unit, step });
    const per = { deg: '1°', '%': '1 %', '': String(by) }[unit];
    const one = (name, slope, bound) => {
        const value = slope * by;
        const direction = Math.abs(value) < LEAST ? '·' : value > 0 ? '▲' : '▼';
        const part = element('span', { className: `${name} ${value > 0 ? 'up' : 'down'}` },
            element('i', { ariaHidden: 'true' }, direction), ` ${number(Math.abs(value), 2)} `, element('small', {}, name));
        part.style.setProperty('--size', Math.min(0.75 + (0.55 * Math.abs(value)) / largest, 1.3));
        const within = bound >= 5e-4 ? ` ±${number(bound * by, 3)}` : '';
        part.title = `${label} ${per} more: ${name} ${signed(value, 3)}${within}`;
        return part;
    };
    return [element('span', { className: 'per' }, `+${per}`), one('Average', average, averageBound), one('Rear', rear, rearBound)];
}
