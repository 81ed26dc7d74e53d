// What the map shows: of each virtual facet a class, and of each class its colour and name.

import { data } from './shared.js';

const { colours } = data;
const EXITED = 0;
const TRAPPED = 1;
const GIRDLE = 2;
const PAVILION = 2;

const NEAR_GIRDLE = { name: 'near the girdle', colour: '#9a9a9a' };
const UNSOLVED = { name: 'trapped', colour: colours.unsolved };
const lows = data.stones[0].score.bands.map(({ low }) => low);

const BANDS = lows.map((low, i) => ({
    name: i === 0 ? `≥ ${low} %` : `${low} – ${lows[i - 1]} %`, colour: colours.bands[i],
}));
const REFLECTIONS = ['#f7f4e3', '#f5d48a', '#eda05a', '#d9644b', '#a83a55', '#6d2459', '#331a4a'];
const TONES = ['#fbe9e7', '#f0b4a8', '#dd7262', '#bd3b37', '#8b1c24'];
const SIN_45 = Math.SQRT1_2;
const SIN_75 = Math.sin((75 * Math.PI) / 180);

/**
 * Each mode: classes, and the class of a virtual facet from the frame's arrays `of` at `i`. Girdle cells and what is
 * trapped come last in all of them.
 */
function mode(name, words, classes, classOf) {
    const all = [...classes, UNSOLVED, NEAR_GIRDLE];
    const [unsolved, girdle] = [classes.length, classes.length + 1];
    return {
        name, words, classes: all,
        classOf(of, i, settings) {
            if (of.status[i] === GIRDLE) return girdle;
            if (of.status[i] === TRAPPED) return unsolved;
            return classOf(of, i, settings);
        },
    };
}

export const MODES = {
    intensity: mode(
        'Intensity', 'Share of the light that reaches the eye, by the paper’s primary intensity',
        [...BANDS, { name: 'rear', colour: colours.rear }],
        (of, i) => (of.rear[i] ? BANDS.length : lows.findIndex((low) => of.intensity[i] >= low)),
    ),
    aset: mode(
        'ASET', 'Where the principal light comes from, by its elevation above the viewer’s horizon',
        [
            { name: 'blue, 75° to 90°', colour: colours.zones.blue },
            { name: 'red, 45° to 75°', colour: colours.zones.red },
            { name: 'green, 0° to 45°', colour: colours.zones.green },
            { name: 'leak, below', colour: colours.zones.leak },
        ],
        (of, i) => {
            const up = of.zenith[i];
            return up > SIN_75 ? 0 : up > SIN_45 ? 1 : up > 0 ? 2 : 3;
        },
    ),
    arrows: mode(
        'Arrows', 'What mirrors the viewer’s head is black, light from beside it red, leakage white',
        [
            { name: 'head', colour: '#111111' },
            ...TONES.toReversed().map((colour, k) => ({ name: `${80 - 20 * k} – ${100 - 20 * k} %`, colour })),
            { name: 'leakage', colour: '#ffffff' },
        ],
        (of, i, { head }) => {
            const up = of.zenith[i];
            if (up > Math.cos((head * Math.PI) / 180)) return 0;
            if (up <= 0) return 1 + TONES.length;
            return 1 + Math.min(Math.floor(((100 - of.intensity[i]) / 100) * TONES.length), TONES.length - 1);
        },
    ),
    reflections: mode(
        'Reflections', 'How often the light is totally reflected on its way',
        REFLECTIONS.map((colour, k) => ({ name: k === REFLECTIONS.length - 1 ? `${k} or more` : `${k}`, colour })),
        (of, i) => Math.min(of.reflections[i], REFLECTIONS.length - 1),
    ),
    window: mode(
        'Window', 'Where one looks through the stone: light that leaves by the pavilion at its first hit',
        [{ name: 'window', colour: '#2b748e' }, { name: 'no window', colour: '#dcdcdc' }],
        (of, i) => (of.status[i] === EXITED && of.reflections[i] === 0 && of.side[i] === PAVILION ? 0 : 1),
    ),
};
