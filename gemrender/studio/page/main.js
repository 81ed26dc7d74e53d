// The page: what is shown is one state (store.js); the server answers with frames (wire.js), and everything is drawn
// from the last of them.

import { announce, byId, data, element, find, hear, number, tip } from './shared.js';
import { Around } from './around.js';
import { Curve } from './curve.js';
import { FacetMap } from './facetmap.js';
import { download, fillSaveMenu, listenToMenus } from './files.js';
import { MODES } from './modes.js';
import { Opening } from './opening.js';
import { Picture, pictureWords } from './picture.js';
import { Profile } from './profile.js';
import { Scores } from './scores.js';
import { Sliders } from './sliders.js';
import { Solid } from './solid.js';
import { Store } from './store.js';
import { Wire } from './wire.js';

const store = new Store(changed);
const map = new FacetMap(find(document, '.view .frame'), {
    tilted: (tilt, azimuth, isAtRest) => tiltTo(tilt, azimuth, isAtRest),
    drawn: (frame) => drawn(frame),
});
const solid = new Solid(find(document, '.stage'), find(document, '.ray'), map);
const sliders = new Sliders(byId('sliders'), moved);
const profile = new Profile(find(document, '.profile'), (values, words) => {
    const { cut } = store.state;
    store.set({ cut: { ...cut, values: { ...cut.values, ...values } } }, words);
});
solid.shown = () => profile.show(solid.stone.mesh, solid.geometry, valuesOf(store.state));
const scores = new Scores(find(document, '.numbers'), {
    light: (which, how) => light(which, how),
    asked: (measures) => store.set({ measures }, measures.length ? `Measures ${measures.join(', ')}` : 'No measures'),
});
const curve = new Curve(find(document, '.curve'), (angle) => tiltTo(Math.abs(angle), angle > 0 ? 90 : -90, true));
const around = new Around(find(document, '.around'), (crown, pavilion) => {
    const values = { ...store.state.cut.values, crown_angle: crown, pavilion_angle: pavilion };
    store.set({ cut: { ...store.state.cut, values } }, `Crown ${number(crown, 2)}°, pavilion ${number(pavilion, 2)}°`);
});
const picture = new Picture(find(document, '.picture'), (wanted) =>
    store.set({ picture: wanted }, wanted ? pictureWords(wanted) : 'No picture'));
let frame = null;
let held = null;
let present = {}; // of a design, what its tiers have by now

const isCurrent = (message) => message.number === store.state?.number;

const wire = new Wire({
    lost() {
        byId('lost').textContent = data.isEmbedded
            ? 'The notebook’s kernel does not answer. What is shown stays; to go on, run the cell again.'
            : 'The studio’s server does not answer. What is shown stays, and goes on as soon as it is back.';
        byId('lost').hidden = false;
        document.body.classList.add('lost');
    },
    found(wasLost) {
        byId('lost').hidden = true;
        document.body.classList.remove('lost');
        if (store.state) wire.want(store.state);
        else opening.begin();
        if (wasLost) announce('The server is back.');
    },
    theme(isDark) {
        setTheme(isDark);
    },
    frame(message) {
        frame = message;
        byId('refused').hidden = true;
        solid.setFrame(frame); // traces the ray that the map shows
        map.setFrame(frame);
        scores.show(frame.score, store.baseline?.score);
        if (!isCurrent(message)) return;
        find(document, '.view .busy').hidden = frame.isSettled;
        present = frame.values;
        if (store.state.cut.design) showValues();
    },
    refused({ why }) {
        refuse(why);
    },
    failed({ why, of }) {
        refuse(why);
        opening.failed(of);
    },
    opened({ stones }) {
        opening.take(stones);
    },
    saved({ name, arrays }) {
        download(name, [arrays.file], 'application/octet-stream');
        announce(`Saved ${name}`);
    },
    slopes(message) {
        if (isCurrent(message)) sliders.setSlopes(message.slopes);
    },
    cliffs(message) {
        if (isCurrent(message)) sliders.setCliffs(message.parameter, message.sides);
    },
    measures(message) {
        if (isCurrent(message)) scores.setMeasures(message);
    },
    curve(message) {
        if (isCurrent(message)) curve.add(message);
    },
    around(message) {
        if (isCurrent(message)) around.add(message);
    },
    picture(message) {
        if (isCurrent(message)) picture.add(message);
    },
    unpictured(message) {
        if (isCurrent(message)) picture.refuse(message.why);
    },
    rested() {
        document.documentElement.dataset.rested = String(store.state.number);
    },
});

const opening = new Opening(store, {
    ask: (message) => wire.ask(message),
    send: (header, bytes) => wire.send(header, bytes),
    refuse,
    rebase: askBaseline,
});

// ---- The state ----

function changed(state, isOther) {
    if (isOther) {
        present = {};
        sliders.fill(store.sliders, valuesOf(state));
        scores.choose(state.measures);
        profile.root.hidden = !('pavilion_angle' in valuesOf(state));
        around.root.hidden = !('crown_angle' in valuesOf(state) && 'pavilion_angle' in valuesOf(state));
    }
    showValues();
    sliders.fade();
    sliders.clearCliffs();
    scores.fade();
    curve.clear();
    around.clear();
    picture.show(state.picture, state.name);
    if (document.activeElement !== byId('name')) byId('name').value = state.name;
    byId('material').value = materialKey(state.material);
    byId('meets').hidden = !state.cut.design;
    find(byId('meets'), 'select').value = state.cut.meets ?? 'loose';
    showMode(state);
    showTilt(state.view);
    showHistory();
    document.title = `${state.name} – gemrender studio`;
    wire.want(state);
}

const valuesOf = (state) => state.cut.values ?? {};

/** The values on the sliders: of a design those that its tiers have by now, the file's own before they are known. */
function shownValues(state, values = {}) {
    if (!state.cut.design) return valuesOf(state);
    const own = Object.fromEntries(store.sliders.map((slider) => [slider.name, slider.value]));
    return { ...own, ...values, ...valuesOf(state) };
}

function showValues() {
    sliders.show(shownValues(store.state, present), store.baseline && shownValues(store.baseline.state));
}

function moved(name, value, words) {
    const { cut } = store.state;
    const values = structuredClone(cut.values);
    const [key, place] = name.split(/\.(?=\d+$)/);
    if (place === undefined) values[name] = value;
    else values[key][Number(place)] = value;
    store.set({ cut: { ...cut, values } }, words);
}

function tiltTo(tilt, azimuth, isAtRest) {
    const view = { tilt: Number(tilt.toFixed(2)), azimuth: Number(azimuth.toFixed(1)) };
    store.set({ view }, isAtRest ? `Tilt ${number(view.tilt, 1)}°` : null);
}

function refuse(why) {
    byId('refused').textContent = why;
    byId('refused').hidden = false;
}

function drawn(of) {
    document.documentElement.dataset.drawn = String(of.number);
    const legend = byId('legend');
    if (legend.dataset.of !== `${map.mode.name}`) fillLegend();
    [...legend.children].forEach((item, i) => {
        const share = map.shares[i];
        item.hidden = i >= map.mode.classes.length - 2 && share < 0.005;
        find(item, 'small').textContent = share > 0 ? ` ${number(share, share < 0.1 ? 2 : 1)} %` : ' 0 %';
    });
}

// ---- Material ----

function materialKey(material) {
    if (material === null || material === undefined) return 'diamond';
    if (typeof material === 'string') return material;
    return 'index';
}

function fillMaterials() {
    const box = byId('material');
    box.append(...data.materials.map((name) => element('option', { value: name }, name)), element('option', { value: 'index' }, 'by refractive index…'));
    box.addEventListener('change', () => {
        let material = box.value;
        if (material === 'index') {
            material = Number(window.prompt('Refractive index', '1.762'));
            if (!(material > 1)) {
                box.value = materialKey(store.state.material);
                return;
            }
        }
        store.set({ material }, `Material ${material}`);
    });
}

// ---- Modes, tilt ----

function fillModes() {
    for (const [key, { name, words }] of Object.entries(MODES)) {
        const button = element('button', { type: 'button', title: words }, name);
        button.dataset.mode = key;
        button.addEventListener('click', () => store.set({ mode: key }, `Map of ${name.toLowerCase()}`));
        byId('modes').append(button);
    }
}

function showMode({ mode, head }) {
    for (const button of byId('modes').children) button.setAttribute('aria-pressed', String(button.dataset.mode === mode));
    if (map.mode !== MODES[mode] || map.settings.head !== head) map.setMode(mode, { head });
}

function fillLegend() {
    byId('legend').dataset.of = map.mode.name;
    byId('legend').replaceChildren(...map.mode.classes.map(({ name, colour }, i) => {
        const swatch = element('span', { className: 'swatch' });
        swatch.style.background = colour;
        const item = element('li', {}, swatch, name, element('small'));
        item.addEventListener('pointerenter', () => map.light(i));
        item.addEventListener('pointerleave', () => map.light(held));
        return item;
    }));
}

function light(which, how) {
    if (how === 'hold') {
        held = held === which ? null : which;
        scores.press(held);
    }
    if (map.mode !== MODES.intensity) return;
    map.light(how === 'point' && which !== null ? which : held);
}

function showTilt({ tilt, azimuth }) {
    for (const [id, value, words] of [['tilt', tilt, `${number(tilt, 1)}°`], ['azimuth', azimuth, `${number(azimuth, 0)}°`]]) {
        const range = byId(id);
        if (document.activeElement !== range) range.value = value;
        find(range.parentElement, 'output').textContent = words;
        range.setAttribute('aria-valuetext', `${number(value, 1)} degrees`);
    }
}

function listenToTilt() {
    const told = (isAtRest) => tiltTo(byId('tilt').valueAsNumber, byId('azimuth').valueAsNumber, isAtRest);
    for (const id of ['tilt', 'azimuth']) {
        byId(id).addEventListener('input', () => told(false));
        byId(id).addEventListener('change', () => told(true));
    }
    byId('level').addEventListener('click', () => tiltTo(0, 0, true));
    byId('lines').addEventListener('click', (event) => {
        map.withLines = !map.withLines;
        event.currentTarget.setAttribute('aria-pressed', String(map.withLines));
        map.redraw();
    });
    for (const button of document.querySelectorAll('[data-map]'))
        button.addEventListener('click', () => ({ in: () => map.zoomBy(1.4), out: () => map.zoomBy(1 / 1.4), whole: () => map.whole() })[button.dataset.map]());
}

// ---- Baseline and history ----

function setBaseline(baseline) {
    store.baseline = baseline;
    for (const id of ['swap', 'drop', 'baseline']) byId(id).hidden = !baseline;
    if (baseline) byId('baseline').textContent = `Baseline: ${baseline.name}, Average ${number(baseline.score.average, 2)}, Rear ${number(baseline.score.rear, 2)}`;
    curve.keep(Boolean(baseline));
    showValues();
    if (frame) scores.show(frame.score, baseline?.score);
}

function keepBaseline() {
    if (!frame || frame.number !== store.state.number) return;
    const { number: _, ...state } = structuredClone(store.state);
    const { average, rear, bands, bound, unsolved } = frame.score;
    const score = { average, rear, bands, bound, unsolved };
    const kept = { state, score, name: state.name, sliders: store.sliders };
    kept.text = JSON.stringify({ state, score, name: state.name });
    setBaseline(kept);
    store.writeLink();
}

/** A baseline out of a link: its numbers are as they were told there, six bands among them. */
function askBaseline({ state, score, name }) {
    const numbers = [score?.average, score?.rear, score?.bound, ...(score?.bands ?? []).map((of) => of?.share)];
    if (!state?.cut || numbers.length < 9 || !numbers.every(Number.isFinite)) return;
    setBaseline({ state, score, name: String(name), sliders: store.sliders, text: JSON.stringify({ state, score, name }) });
}

function showHistory() {
    byId('undo').disabled = store.place <= 0;
    byId('redo').disabled = store.place >= store.steps.length - 1;
    const list = find(byId('history'), '.list');
    list.replaceChildren(...store.steps.map(({ words }, place) => {
        const button = element('button', { type: 'button' }, words);
        if (place === store.place) button.setAttribute('aria-current', 'step');
        button.addEventListener('click', () => store.go(place));
        return button;
    }).reverse());
}

function listenToHistory() {
    byId('undo').addEventListener('click', () => store.undo());
    byId('redo').addEventListener('click', () => store.redo());
    byId('keep').addEventListener('click', keepBaseline);
    byId('drop').addEventListener('click', () => setBaseline(null));
    byId('swap').addEventListener('click', () => {
        const { state, sliders: of } = store.baseline;
        store.open(structuredClone(state), of, 'Baseline');
    });
    document.addEventListener('keydown', (event) => {
        if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
        const key = event.key.toLowerCase();
        if (/^(text|number)$/.test(event.target.type ?? '') && (key === 'z' || key === 'y')) return;
        if (key === 'z' && !event.shiftKey) store.undo();
        else if (key === 'y' || (key === 'z' && event.shiftKey)) store.redo();
        else return;
        event.preventDefault();
    });
}

// ---- Saving ----

async function save(kind) {
    if (!frame) return;
    if (kind === 'map') {
        map.base.toBlob((blob) => download(`${store.state.name.replace(/[^\w.-]+/g, '-')}.png`, [blob], 'image/png'));
        return;
    }
    if (kind === 'link') {
        store.writeLink();
        setTimeout(async () => {
            try {
                await navigator.clipboard.writeText(location.href);
                announce('Link copied.');
            } catch {
                window.prompt('Link', location.href);
            }
        }, 600);
        return;
    }
    wire.ask({ type: 'save', kind, state: store.state });
}

// ---- The page ----

function setTheme(isDark) {
    document.documentElement.dataset.theme = isDark ? 'dark' : 'light';
    byId('theme').setAttribute('aria-pressed', String(isDark));
}

function listenToPage() {
    const root = document.documentElement;
    setTheme(root.dataset.theme === 'dark');
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', (event) => setTheme(event.matches));
    byId('theme').addEventListener('click', () => setTheme(root.dataset.theme !== 'dark'));
    byId('name').addEventListener('change', () => store.set({ name: byId('name').value.trim() || 'stone' }, `Name ${byId('name').value}`));
    find(byId('meets'), 'select').addEventListener('change', (event) => {
        const meets = event.target.value;
        store.set({ cut: { ...store.state.cut, meets } }, `Meets ${meets}`);
    });
    document.addEventListener('scroll', () => tip.hide(), { passive: true });
    byId('generator').textContent = `${data.generator}. The map is made of exact virtual facets; the ray is traced in this page, in double precision. The stone is drawn by three.js (MIT licence).`;
}

hear.choose = (point) => solid.choose(point);
fillMaterials();
fillModes();
fillSaveMenu(save);
listenToTilt();
listenToHistory();
listenToMenus();
listenToPage();
solid.point = { x: 0.28, y: 0.16 };
document.documentElement.dataset.ready = 'true';
