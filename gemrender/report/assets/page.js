'use strict';

// The page: for each stone a stage (3D), a map and the ray through the chosen point (card.js), linked with each other
// and with the other stones; above them the table of scores, beside them what the stones have in common.

(() => {
    const { number, find, boundText, typeset, element, tip, announce } = GemDom;
    const { data, choices, values, cards, traceOn, lights } = GemPage;
    const { REAR } = GemLight;
    const { Card } = GemCard;
    const { colours } = data;

    /** Most stones that have a column each in the tables below. */
    const MOST_COLUMNS = 4;
    const PAPER = matchMedia('print');
    /** What is rear light, by the model's rule. */
    const REAR_WORDS = {
        position: 'Light that comes in at or below height 0, the girdle’s lower edge, is rear light.',
        facet: 'Light that comes in through a facet of the pavilion is rear light.',
        direction: 'Light that comes from below the horizon is rear light.',
    };

    cards.push(...data.stones.map((stone, place) => new Card(stone, place)));

    /** Show what was chosen: the tilt, and the ray at the same point of every stone. */
    function showChosen(changed) {
        if (!('turn' in changed || 'point' in changed)) return;
        if ('turn' in changed) cards.forEach((card) => card.setTurn());
        for (const card of cards) card.choose(choices.point);
        traceOn();
        announce(
            cards
                .map((card) => `${cards.length > 1 ? `${card.stone.name}: ` : ''}${number(card.path.intensity, 1)} %. ${card.sentence}`)
                .join(' '),
        );
    }

    /** A ray to begin with: bright, and reflected a few times. */
    function firstPoint() {
        const candidates = [];
        for (const radius of [0.34, 0.42, 0.28, 0.62, 0.5])
            for (const azimuth of [201, 219, 246, 264, 21, 39]) {
                const turn = (azimuth * Math.PI) / 180;
                candidates.push({ x: radius * Math.cos(turn), y: radius * Math.sin(turn) });
            }
        const isGood = (point) => {
            const path = cards[0].trace(point, cards[0].stone.view.basis);
            return path.intensity > 55 && path.reflections === 2;
        };
        return candidates.find(isGood) ?? candidates[0];
    }

    /** Properties in rows and stones in columns; of many stones, the other way round. */
    function table(root, heads, rows) {
        if (heads.length - 1 > MOST_COLUMNS) {
            const [, ...names] = heads;
            heads = ['', ...rows.map(({ cells: [name] }) => name)];
            rows = names.map((name, i) => ({ cells: [name, ...rows.map(({ cells }) => cells[i + 1])] }));
        }
        const head = element('tr', {}, ...heads.map((text) => element('th', { scope: 'col' }, text)));
        const body = rows.map(({ cells: [name, ...values], swatch, strong }) => {
            const mark = element('span', { className: 'swatch' });
            if (swatch) mark.style.background = swatch;
            const th = element('th', { scope: 'row' }, ...(swatch ? [mark] : []), name);
            const row = element('tr', {}, th, ...values.map((value) => element('td', {}, value)));
            if (strong) row.className = 'strong';
            return row;
        });
        root.replaceChildren(element('thead', {}, head), element('tbody', {}, ...body));
    }

    function fillTables() {
        const { stones } = data;
        const names = stones.length > 1 ? stones.map((stone) => stone.name) : [''];
        const ofEach = (value) => stones.map((stone) => value(stone));
        find(document, '.tables').classList.toggle('many', stones.length > MOST_COLUMNS);
        find(document, '.reading').classList.toggle('wide', stones.length > 1);

        const proportions = document.getElementById('proportions');
        // Of stones of different cuts all that any of them has.
        const rowNames = [...new Set(stones.flatMap((stone) => stone.proportions.map(({ name }) => name)))];
        const proportion = (stone, wanted) => {
            const found = stone.proportions.find(({ name }) => name === wanted);
            return found ? number(found.value, 2) + (found.unit === '%' ? ' %' : found.unit) : '–';
        };
        const rows = rowNames.map((name) => ({ cells: [name, ...ofEach((stone) => proportion(stone, name))] }));
        rows.push(
            { cells: ['Material', ...ofEach(({ material, model }) => material ?? (model.index === 2.4173 ? 'diamond' : '–'))] },
            { cells: ['Refractive index', ...ofEach(({ model }) => number(model.index, 4))] },
            { cells: ['Critical angle', ...ofEach(({ criticalAngle }) => `${number(criticalAngle, 2)}°`)] },
        );
        table(find(proportions, 'table'), ['', ...names], rows);
        find(proportions, 'thead').hidden = stones.length === 1;
        const measured = stones.filter((stone) => stone.measured).map((stone) => stone.name);
        find(proportions, '.note').textContent =
            [...new Set(stones.map((stone) => stone.proportionsText))].join(' ') +
            (measured.length ? ` Means over the vertices: ${measured.join(', ')}.` : '');
    }

    /** The table on top as paper has it: one for each measure, with its definition. */
    function fillPaper() {
        const names = data.stones.map((stone) => stone.name);
        const upright = values.turns.indexOf(0);
        const ofEach = (text) => names.map((_, stone) => text(stone));
        const parts = values.groups.map((group, i) => {
            const rows = values.columns.filter((column) => column.group === i).map((column) => ({
                cells: [column.label, ...ofEach((stone) => {
                    const value = values.value(stone, upright, column.key);
                    return value === null ? '–' : number(value, column.decimals);
                })],
                swatch: column.band !== null ? colours.bands[column.band] : column.key === 'rear' ? colours.rear : null,
                strong: i === 0 && column.band === null,
            }));
            const bounds = ofEach((stone) => values.bounds[stone][upright][i]);
            if (bounds.some((bound) => bound !== null))
                rows.push({ cells: ['Each within', ...bounds.map((bound) => (bound === null ? '–' : `±${boundText(bound)}`))] });
            const made = element('table');
            table(made, ['', ...names], rows);
            const note = element('p', { className: 'note' }, `${typeset(group.definition)}. Source: ${group.source}.`);
            return element('div', {}, element('h2', {}, i === 0 ? 'Scores' : group.name), made, ...(i === 0 ? [] : [note]));
        });
        document.getElementById('comparison').append(...parts);
    }

    /** The table on top and the tilts, unless the only stone's own scores are all there is. */
    function fillTop() {
        const top = document.getElementById('scores');
        const isAlone = data.stones.length === 1 && values.groups.length === 1;
        top.hidden = isAlone && values.turns.length === 1;
        document.getElementById('comparison').hidden = isAlone;
        if (!isAlone) fillPaper();
        GemPage.scoreTable = new GemScores.ScoreTable(top, {
            values, choices, colours, show: (stone) => showStone(stone),
            point: (band) => lights.point(band === 'rear' ? REAR : band),
        });
        new GemTilts.Tilts(find(top, '.tilt'), document.getElementById('curve'), { values, choices });
        new ResizeObserver(() => {
            document.documentElement.style.setProperty('--top', `${top.offsetHeight}px`);
        }).observe(top);
    }

    /** Bring a stone into sight. */
    function showStone(stone) {
        choices.set({ stone });
        cards[stone].root.scrollIntoView({ block: 'start' });
    }

    /** Take over what the link says. */
    function followLink() {
        choices.read();
        choices.point ??= firstPoint();
        for (const hear of choices.hear) hear(choices);
        if (choices.stone > 0) cards[choices.stone].root.scrollIntoView({ block: 'start' });
    }

    function fillHeading() {
        const { stones } = data;
        document.getElementById('title').textContent =
            stones.length === 1 ? stones[0].name : `${stones.length} stones compared`;
        const unique = (values) => [...new Set(values)].join('; ');
        const text = unique(stones.map((stone) => stone.modelText));
        document.getElementById('rules').textContent = `${text[0].toUpperCase()}${text.slice(1)}.`;
        document.getElementById('units').textContent = [
            `Lengths are in ${unique(stones.map((stone) => stone.unit))}.`,
            ...new Set(stones.map((stone) => REAR_WORDS[stone.model.rear])),
        ].join(' ');
        const engines = unique(stones.map((stone) => stone.engineText));
        document.getElementById('generator').textContent =
            `${data.generator}. Map: ${engines}. The ray${values.turns.length > 1 ? ', and the map of tilted stones,' : ''} is traced in this page, in double precision. ` +
            'The stone is drawn by three.js (MIT licence).';
    }

    function listenToPage() {
        const root = document.documentElement;
        const button = document.getElementById('theme');
        const system = matchMedia('(prefers-color-scheme: dark)');
        const setTheme = (isDark) => {
            root.dataset.theme = isDark ? 'dark' : 'light';
            button.setAttribute('aria-pressed', String(isDark));
        };
        setTheme(root.dataset.theme === 'dark');
        system.addEventListener('change', (event) => setTheme(event.matches));
        button.addEventListener('click', () => setTheme(root.dataset.theme !== 'dark'));
        document.getElementById('print').addEventListener('click', () => window.print());
        document.addEventListener('scroll', () => tip.hide(), { passive: true });
        PAPER.addEventListener('change', () => cards.forEach((card) => card.draw()));
        window.addEventListener('beforeprint', () => {
            for (const card of cards) {
                if (!card.map.isDone) card.map.trace(Infinity);
                card.draw();
            }
        });
    }

    async function start() {
        listenToPage();
        fillHeading();
        fillTables();
        fillTop();
        const parent = document.getElementById('stones');
        await Promise.all(cards.map((card) => card.map.load()));
        const seen = cards.map((card) => card.build(parent));
        choices.hear.push(showChosen);
        followLink();
        window.addEventListener('hashchange', followLink);
        await Promise.all(seen);
        requestAnimationFrame(() => requestAnimationFrame(() => {
            document.documentElement.dataset.ready = 'true';
        }));
    }

    start().catch((error) => {
        const text = `This browser cannot draw the page (${error.message}); a newer one can.`;
        document.getElementById('stones').replaceChildren(element('p', { className: 'notice' }, text));
        throw error;
    });
})();
