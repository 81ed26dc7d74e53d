'use strict';

// What the stones of the page share: the data, what is chosen, the band of light that is brought out, and what is
// said beside the pointer and aloud; the cards and the table on top are made by `page.js`. All data is in #data.

const GemPage = (() => {
    const { find } = GemDom;
    const data = JSON.parse(document.getElementById('data').textContent);
    const choices = new GemChoices.Choices(data);
    const values = new GemScores.Values(data);
    /** One for each stone, in the data's order; filled when the page is made. */
    const cards = [];

    /** Time in each frame for tracing the maps of tilted views [ms]. */
    const TRACING_TIME = 12;
    /** Such a map is drawn as it gets finer, and at least so often [ms]: drawing takes as long as tracing. */
    const DRAWN_EVERY = 100;

    /** Trace on at the maps of tilted views that are in sight, the coarsest first, frame by frame. */
    let isTracing = false;
    function traceOn() {
        if (isTracing) return;
        isTracing = true;
        requestAnimationFrame(function step() {
            const waiting = cards.filter((card) => card.isInSight && !card.map.isDone);
            isTracing = waiting.length > 0;
            if (!isTracing) return;
            const card = waiting.reduce((a, b) => (b.map.stride > a.map.stride ? b : a));
            const now = performance.now();
            const { stride } = card.map;
            card.map.trace(now + TRACING_TIME);
            if (card.map.stride < stride || now - card.mapView.drawnAt > DRAWN_EVERY) card.mapView.draw();
            requestAnimationFrame(step);
        });
    }

    /** Choose a point, in one of the stones. */
    function choose(point, card) {
        choices.set({ point, stone: card.place });
    }

    const press = (row, isHeld) => find(row, 'button').setAttribute('aria-pressed', String(isHeld));

    /** The band of light that is brought out in all maps: what is pointed at, or was pressed. */
    const lights = {
        pointed: null,
        held: null,
        get kind() {
            return this.pointed ?? this.held;
        },
        point(kind) {
            if (kind === this.pointed) return;
            this.pointed = kind;
            cards.forEach((card) => card.redrawMap());
        },
        hold(kind) {
            this.held = this.held === kind ? null : kind;
            this.show();
            cards.forEach((card) => card.redrawMap());
        },
        show() {
            for (const row of document.querySelectorAll('[data-kind]'))
                press(row, Number(row.dataset.kind) === this.held);
        },
    };

    return {
        data, choices, values, cards, traceOn, choose, press, lights,
        scoreTable: null, // made when the page is
    };
})();
