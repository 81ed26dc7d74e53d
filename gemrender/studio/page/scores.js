// Scores with their bounds, the bands, differences from a baseline, and further measures.

import { boundText, data, define, element, find, number, signed } from './shared.js';
import { MODES } from './modes.js';

/** A smaller share of light that is trapped is not told [%]. */
const LEAST_SHOWN = 0.005;

const bandColour = (i) => MODES.intensity.classes[i].colour;

function share(value) {
    const digits = value === 0 || value >= 0.05 ? 1 : Math.min(2 - Math.ceil(Math.log10(value)), 4);
    return `${number(value, digits)} %`;
}

export class Scores {
    constructor(root, { light, asked }) {
        Object.assign(this, { root, light, asked });
        this.baseline = null;
        this.values = new Map();
        this.fillMeasures();
    }

    show(score, baseline) {
        const { root } = this;
        for (const key of ['average', 'rear']) {
            const parts = [number(score[key], 2), element('small', {}, ` ±${boundText(score.bound)} %`)];
            if (baseline) {
                const by = score[key] - baseline[key];
                const isSame = Math.abs(by) <= score.bound + baseline.bound;
                parts.push(element('span', { className: `by${isSame ? ' within' : ''}` }, signed(by, 2)));
            }
            find(root, `.${key}`).replaceChildren(...parts);
        }
        const rows = score.bands.map(({ name, share: of }, i) => [i, `${name} %`, of, baseline?.bands[i].share]);
        rows.push([score.bands.length, 'Rear', score.rear, baseline?.rear]);
        if (score.unsolved >= LEAST_SHOWN) rows.push([score.bands.length + 1, 'Trapped', score.unsolved, baseline?.unsolved]);
        const widest = Math.max(...rows.map((row) => row[2]));
        const body = find(root, '.bands tbody');
        while (body.children.length > rows.length) body.lastChild.remove();
        rows.forEach(([which, name, of, before], k) => {
            const row = body.children[k] ?? this.row(body, which);
            find(row, '.swatch').style.background = bandColour(which);
            find(row, '.words').textContent = name;
            find(row, '.bar i').style.background = bandColour(which);
            find(row, '.bar i').style.width = `${(42 * of) / widest}%`;
            const by = before === undefined ? '' : ` ${signed(of - before, 1)}`;
            find(row, '.bar span').replaceChildren(share(of), element('small', {}, by));
        });
        const near = score.nearGirdle >= 0.005 ? `, and ${number(score.nearGirdle, 2)} % near the girdle by single rays` : '';
        const rules = score.modelText;
        find(root, '#rules').textContent =
            `${score.facets} virtual facets${near}. ${rules[0].toUpperCase()}${rules.slice(1)}. ± holds with 99.9 % confidence. ${score.notes.join(' ')}`;
    }

    row(body, which) {
        const swatch = element('span', { className: 'swatch' });
        const button = element('button', { type: 'button' }, swatch, element('span', { className: 'words' }));
        const row = element('tr', {},
            element('th', { scope: 'row' }, button),
            element('td', {}, element('div', { className: 'bar' }, element('i'), element('span'))),
        );
        button.setAttribute('aria-pressed', 'false');
        row.addEventListener('pointerenter', (event) => event.pointerType !== 'touch' && this.light(which, 'point'));
        row.addEventListener('pointerleave', () => this.light(null, 'point'));
        button.addEventListener('click', () => this.light(which, 'hold'));
        body.append(row);
        return row;
    }

    press(held) {
        [...find(this.root, '.bands tbody').children].forEach((row, i) => find(row, 'button').setAttribute('aria-pressed', String(i === held)));
    }

    // ---- Further measures ----

    fillMeasures() {
        const rows = data.measures.map((of) => {
            const box = element('input', { type: 'checkbox', value: of.name, id: `measure-${of.name}` });
            box.addEventListener('change', () => this.asked([...this.root.querySelectorAll('#measures input:checked')].map(({ value }) => value)));
            const about = element('button', { type: 'button', className: 'about' }, '?');
            about.setAttribute('aria-label', `What ${of.name} is`);
            about.addEventListener('click', () => define(of.name, of.definition, of.source));
            return element('div', { className: 'measure' }, box, element('label', { htmlFor: box.id }, of.name), about, element('dl'));
        });
        find(this.root, '#measures').append(...rows);
    }

    choose(names) {
        for (const box of this.root.querySelectorAll('#measures input')) {
            box.checked = names.includes(box.value);
            if (!box.checked) find(box.parentElement, 'dl').replaceChildren();
        }
        if (names.length) find(this.root, '.further').open = true;
    }

    setMeasures({ measures, unit, why }) {
        for (const { name, values, bound } of measures) {
            const row = document.getElementById(`measure-${name}`)?.parentElement;
            if (!row) continue;
            const sign = unit === '%' ? ' %' : unit ? ` ${unit}` : '';
            const within = bound === null ? '' : ` ±${boundText(bound)}`;
            find(row, 'dl').replaceChildren(...Object.entries(values).map(([key, value]) =>
                element('div', {},
                    element('dt', {}, key === 'value' ? '' : key.replaceAll('_', ' ')),
                    element('dd', {}, value === null ? '–' : number(value, 2) + sign, element('small', {}, within)),
                )));
            row.classList.remove('stale');
        }
        if (why) find(this.root, '#measures').title = why;
    }

    fade() {
        for (const row of this.root.querySelectorAll('.measure')) row.classList.add('stale');
    }
}
