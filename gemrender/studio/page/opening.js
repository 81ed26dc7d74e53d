// What is opened: a stone of the lists, a file that was dropped, or the state of a link.

import { byId, data, element } from './shared.js';
import { listenForFiles } from './files.js';
import { MODES } from './modes.js';
import { Store } from './store.js';

/** The stone that the page begins with where no other one can be opened. */
const FIRST = { type: 'open', bundled: 'inoue-3' };

export class Opening {
    /** `ask(message)` and `send(header, bytes)` reach the server; `refuse(words)`; `rebase(baseline)` of a link. */
    constructor(store, reach) {
        Object.assign(this, { store, reach });
        this.file = null; // name of the file that is being opened
        this.link = null; // the link that is being opened
        this.dropped = new Map();
        this.fill();
        listenForFiles((name, bytes) => {
            this.file = name;
            reach.send({ type: 'drop', name }, bytes);
        }, reach.refuse);
        window.addEventListener('hashchange', () => this.follow());
    }

    /** Open what the page begins with. */
    async begin() {
        if (await this.follow()) return;
        this.reach.ask(data.shelf.length ? { type: 'open', key: data.shelf[0].key } : FIRST);
    }

    /** Open the link's state; false if it has none. */
    async follow() {
        const link = await Store.readLink();
        if (!link) return false;
        this.link = link;
        this.reach.ask({ type: 'open', cut: link.state.cut, name: link.state.name, material: link.state.material });
        return true;
    }

    /** Show stones that were opened. */
    take(stones) {
        const [first] = stones;
        if (stones.length > 1) this.list(stones);
        const { link } = this;
        this.link = this.file = null;
        if (!link) {
            this.store.open(this.begun(first), first.sliders, `Open ${first.name}`);
            return;
        }
        this.store.open(checked(link.state, this.begun(first)), first.sliders, 'Link');
        if (link.baseline) this.reach.rebase(link.baseline);
    }

    /** Something could not be opened, or what else was asked for. */
    failed(of) {
        this.file = this.link = null;
        if (of === 'open' && !this.store.state) this.reach.ask(FIRST);
    }

    begun({ cut, name, material, size_mm }) {
        const { head = 10, measures = [], mode = 'intensity', picture = null } = this.store.state ?? {};
        return { cut, name, material, size_mm, view: { tilt: 0, azimuth: 0 }, head, measures, mode, picture };
    }

    // ---- The list ----

    /** List the stones of a file, the first one chosen. */
    list(stones) {
        const group = element('optgroup', { label: this.file ?? 'File' });
        stones.forEach((of, i) => {
            const key = `dropped ${this.file} ${i}`;
            this.dropped.set(key, of);
            group.append(element('option', { value: key }, of.name));
        });
        byId('stones').prepend(group);
        byId('stones').value = group.firstChild.value;
    }

    fill() {
        const option = (value, text) => element('option', { value }, text);
        const group = (label, options) => element('optgroup', { label }, ...options);
        const box = byId('stones');
        if (data.shelf.length) box.append(group('Opened', data.shelf.map(({ key, name }) => option(`key ${key}`, name))));
        box.append(
            group('New', data.families.map((name) => option(`family ${name}`, name))),
            group('Bundled', data.bundled.map((name) => option(`bundled ${name}`, name))),
        );
        box.addEventListener('change', () => {
            if (this.dropped.has(box.value)) {
                this.take([this.dropped.get(box.value)]);
                return;
            }
            const [, kind, name] = box.value.match(/^(\w+) (.*)$/);
            this.reach.ask({ type: 'open', [kind]: name });
        });
        box.append(element('option', { value: 'other', hidden: true }, 'Other'));
    }
}

/** The state of a link, as far as the page itself relies on it; the server checks the rest. */
function checked(state, plain) {
    const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
    const { number: _, ...out } = { ...plain, ...state, cut: { ...state.cut, values: { ...state.cut.values } } };
    if (!(out.mode in MODES)) out.mode = plain.mode;
    if (!isNumber(out.view?.tilt) || !isNumber(out.view?.azimuth)) out.view = plain.view;
    if (!isNumber(out.head)) out.head = plain.head;
    if (!Array.isArray(out.measures)) out.measures = [];
    if (!data.setups.includes(out.picture?.setup)) out.picture = null;
    const { setting, metal } = out.picture ?? {};
    const isHeld = (setting === undefined || data.settings.includes(setting)) && (metal === undefined || data.metals.includes(metal));
    if (!isHeld) out.picture = { ...out.picture, setting: undefined, metal: undefined };
    out.name = String(out.name).slice(0, 100);
    return out;
}
