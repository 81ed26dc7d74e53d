'use strict';

// The ray through the chosen point in words and numbers: its way, its intensity as a product, and the table of its
// path.

const GemRay = (() => {
    const { STATUS } = GemTracer;
    const { number, element } = GemDom;
    const { codes } = GemPage.data;
    const { stationNames } = GemLight;

    /** Most rows of a path's table. */
    const MOST_ROWS = 60;
    /** Largest difference between the map and the ray traced here that is rounding [%]. */
    const SAME_INTENSITY = 0.05;

    const facetName = (name) => name.replace(/^bezel_/, 'bezel_main_').replaceAll('_', ' ');
    /** A facet within a sentence: a word, such as "the table" or "star 1", or a designer's name: "facet P1 24". */
    function theFacet(name) {
        if (!/^[a-z]{3}/.test(name)) return `facet ${facetName(name)}`;
        return (/_/.test(name) ? '' : 'the ') + facetName(name);
    }
    const times = (count) => (count === 1 ? 'once' : count === 2 ? 'twice' : `${count} times`);

    function sentence(path, names) {
        if (path.status === STATUS.MISSED) return 'Outside the stone.';
        const seen = theFacet(names[path.facets[0]]);
        if (path.status === STATUS.TRAPPED)
            return `Seen through ${seen}; no light comes this way: after ${path.reflections} reflections it is still inside.`;
        if (path.status === STATUS.LOST) return `Seen through ${seen}; lost to rounding.`;
        const where = `Light comes in through ${theFacet(names[path.facets.at(-1)])}`;
        const way = path.reflections ? `is totally reflected ${times(path.reflections)} and ` : '';
        const end = `${way}reaches the eye through ${seen}.`;
        if (path.rear) return `${where}: rear light, counted as 0. It ${end}`;
        return where + (way ? `, ${end}` : ` and ${end}`);
    }

    /** The intensity as a product of what both crossings let through. */
    function product(path, model) {
        if (!path.factors) return [];
        const { tIn, sIn, tOut, sOut } = path.factors;
        const factor = (letter, place, value) =>
            element('span', {}, '× ', element('i', {}, letter), element('sub', {}, place), ` ${number(value, 3)}`);
        const isPrimary = model.intensity === 'primary';
        const terms = [
            factor('T', 'in', tIn), ...(isPrimary ? [factor('S', 'in', sIn)] : []),
            factor('T', 'out', tOut), ...(isPrimary ? [factor('S', 'out', sOut)] : []),
        ];
        const value = `${number(100 * tIn * sIn * tOut * sOut, 2)} %`;
        const before = path.rear ? ['Would be '] : [];
        const result = element('span', {}, '= ', path.rear ? value : element('b', {}, value));
        return [...before, '100 %', ...[...terms, result].flatMap((term) => [' ', term])];
    }

    /** What to say where the map's tracer and the page's followed different rays; else null. */
    function difference(code, path) {
        if (code === codes.outside && path.status === STATUS.MISSED) return null;
        const isLit = path.status === STATUS.EXITED && !path.rear;
        const mapped = (code + 0.5) / codes.steps;
        if (code < codes.rear && isLit && Math.abs(mapped - path.intensity) < SAME_INTENSITY) return null;
        if (code === codes.rear && path.status === STATUS.EXITED && path.rear) return null;
        if (code === codes.unsolved && path.status >= STATUS.TRAPPED) return null;
        const names = { [codes.rear]: 'rear light', [codes.unsolved]: 'trapped', [codes.outside]: 'outside the stone' };
        return (
            `The map has ${names[code] ?? `${number(mapped, 2)} %`} here. At the edge of a facet, or after many ` +
            'reflections, rounding decides which way a ray goes.'
        );
    }

    /** The rows of the path's table, in the order in which the light meets the surface. */
    function pathRows(path, facetNames) {
        const names = stationNames(path);
        const isOut = path.status === STATUS.EXITED;
        const last = path.points.length - 1;
        const order = [...path.points.keys()];
        if (isOut) order.reverse();
        const degrees = (angle) => (angle === null ? '' : `${number(angle, 2)}°`);
        const share = (value) => (value === null ? '' : number(value, 3));
        const rows = order.slice(0, MOST_ROWS).map((i) => {
            const [before, after] = GemTracer.anglesAt(path, i);
            let [inStone, inAir, t, s] = [before, null, null, null];
            if (i === 0) {
                [inAir, inStone] = [before, after];
                if (isOut) [t, s] = [path.factors.tOut, path.factors.sOut];
            } else if (isOut && i === last) {
                inAir = after;
                [t, s] = [path.factors.tIn, path.factors.sIn];
            }
            const row = element('tr', {},
                ...[
                    names[i], facetName(facetNames[path.facets[i]]), degrees(inStone), degrees(inAir), share(t), share(s),
                    number(path.points[i][2], 3),
                ].map((text) => element('td', {}, text)),
            );
            row.dataset.facet = facetNames[path.facets[i]];
            return row;
        });
        if (order.length > MOST_ROWS) {
            const cell = element('td', { colSpan: 7 }, `and ${order.length - MOST_ROWS} more`);
            rows.push(element('tr', {}, cell));
        }
        return rows;
    }

    return Object.freeze({ facetName, sentence, product, difference, pathRows });
})();
