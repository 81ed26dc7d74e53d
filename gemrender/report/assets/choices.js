'use strict';

// What is chosen, kept in the page's link.

const GemChoices = (() => {
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

    return Object.freeze({ Choices });
})();
