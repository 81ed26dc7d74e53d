'use strict';

// What the page tells in numbers of all stones together: the table on top with its definitions. `page.js` puts it to
// work; all data is the page's.

const GemScores = (() => {
    const { number, find, signed, boundText, element, define } = GemDom;

    /** Values of the table, by stone and turn. */
    class Values {
        constructor({ stones, table }) {
            Object.assign(this, { ...table, names: stones.map(({ name }) => name) });
            this.places = new Map(table.columns.map(({ key }, i) => [key, i]));
        }

        value(stone, turn, key) {
            return this.values[stone][turn][this.places.get(key)] ?? null;
        }

        bound(stone, turn, key) {
            return this.bounds[stone][turn][this.columns[this.places.get(key)].group];
        }

        /** A column's name where it stands alone: "Average", "iso", "aset green". */
        title({ key, label, group }) {
            const { name } = this.groups[group];
            return group === 0 ? label : key === name ? name : `${name} ${label}`;
        }

        unit({ group, decimals }) {
            const { unit } = this.groups[group];
            return decimals === 0 ? '' : unit;
        }
    }

    /** The table on top: a row a stone, sorted by any column; against a baseline, the differences from it. */
    class ScoreTable {
        constructor(root, { values, choices, colours, point, show }) {
            Object.assign(this, { root, values, choices, colours, point, show });
            this.body = element('tbody');
            this.heads = new Map();
            find(root, 'table').append(this.head(), this.body);
            this.fillBaseline();
            find(root, '#csv').addEventListener('click', () => this.download());
            choices.hear.push((changed) => ['sort', 'isDown', 'baseline', 'turn'].some((key) => key in changed) && this.fill());
            this.fill();
        }

        head() {
            const { groups, columns } = this.values;
            const runs = []; // columns of one measure that stand side by side
            for (const { group } of columns)
                if (runs.at(-1)?.group === group) runs.at(-1).length += 1;
                else runs.push({ group, length: 1 });
            const upper = runs.map(({ group, length }) => {
                const { name } = groups[group];
                const button = element('button', { type: 'button', className: 'define' }, name);
                button.setAttribute('aria-haspopup', 'dialog');
                button.title = `Definition and source of ${name}`;
                button.addEventListener('click', () => defineGroup(groups[group]));
                return element('th', { scope: 'colgroup', colSpan: length, className: 'first' }, button);
            });
            const lower = columns.map((column, i) => {
                const isFirst = i === 0 || columns[i - 1].group !== column.group;
                return this.sorter(column.key, column.label, column, isFirst ? 'first' : '');
            });
            const name = this.sorter('name', 'Stone', {}, '');
            name.rowSpan = 2;
            return element('thead', {}, element('tr', {}, name, ...upper), element('tr', {}, ...lower));
        }

        sorter(key, label, { band }, className) {
            const button = element('button', { type: 'button' }, ...this.swatch(key, band), label);
            const head = element('th', { scope: 'col', className }, button);
            button.addEventListener('click', () => {
                // First the way that tells most: names from A, numbers from the largest; then the other; then none.
                const { sort, isDown } = this.choices;
                const first = key !== 'name';
                if (sort !== key) this.choices.set({ sort: key, isDown: first });
                else if (isDown === first) this.choices.set({ isDown: !first });
                else this.choices.set({ sort: null, isDown: false });
            });
            this.listen(head, key, band);
            this.heads.set(key, head);
            return head;
        }

        swatch(key, band) {
            const colour = band != null ? this.colours.bands[band] : key === 'rear' ? this.colours.rear : null;
            if (colour === null) return [];
            const mark = element('span', { className: 'swatch' });
            mark.style.background = colour;
            return [mark];
        }

        /** What is pointed at here lights up in the maps. */
        listen(cell, key, band) {
            const pointed = band ?? (key === 'rear' ? 'rear' : null);
            if (pointed === null) return;
            cell.dataset.band = pointed;
            cell.addEventListener('pointerenter', () => this.point(pointed));
            cell.addEventListener('pointerleave', () => this.point(null));
        }

        fillBaseline() {
            const { names } = this.values;
            const box = find(this.root, '#baseline');
            box.closest('label').hidden = names.length === 1;
            box.append(element('option', { value: '' }, 'none'));
            names.forEach((name, i) => box.append(element('option', { value: i }, name)));
            box.addEventListener('change', () =>
                this.choices.set({ baseline: box.value === '' ? null : Number(box.value) }),
            );
            this.box = box;
        }

        /** Numbers of the stones, in the table's order: without a value last. */
        order() {
            const { sort, isDown, turn } = this.choices;
            const stones = [...this.values.names.keys()];
            if (sort === null) return stones;
            const keyOf = (i) => (sort === 'name' ? this.values.names[i] : this.values.value(i, turn, sort));
            const compare = sort === 'name' ? (a, b) => a.localeCompare(b, 'en') : (a, b) => a - b;
            return stones.sort((i, j) => {
                const [a, b] = [keyOf(i), keyOf(j)];
                if (a === null || b === null) return (a === null) - (b === null);
                return isDown ? compare(b, a) : compare(a, b);
            });
        }

        fill() {
            const { sort, isDown, baseline } = this.choices;
            this.box.value = baseline ?? '';
            for (const [key, head] of this.heads) {
                if (key === sort) head.setAttribute('aria-sort', isDown ? 'descending' : 'ascending');
                else head.removeAttribute('aria-sort');
            }
            this.body.replaceChildren(...this.order().map((stone) => this.row(stone)));
        }

        row(stone) {
            const { names, columns } = this.values;
            const button = element('button', { type: 'button' }, names[stone]);
            button.addEventListener('click', () => this.show(stone));
            const row = element('tr', {}, element('th', { scope: 'row' }, button));
            row.dataset.stone = stone;
            const { baseline } = this.choices;
            if (baseline === stone) row.className = 'baseline';
            columns.forEach((column, i) => {
                const isDifference = baseline !== null && baseline !== stone;
                const cell = isDifference ? this.difference(stone, column) : this.cell(stone, column);
                if (i === 0 || columns[i - 1].group !== column.group) cell.classList.add('first');
                this.listen(cell, column.key, column.band);
                row.append(cell);
            });
            return row;
        }

        cell(stone, { key, decimals }) {
            const { turn } = this.choices;
            const value = this.values.value(stone, turn, key);
            if (value === null) return element('td', {}, '–');
            return element('td', {}, number(value, decimals), ...bounded(this.values.bound(stone, turn, key), decimals));
        }

        difference(stone, { key, decimals }) {
            const { turn, baseline } = this.choices;
            const [value, from] = [stone, baseline].map((i) => this.values.value(i, turn, key));
            if (value === null || from === null) return element('td', {}, '–');
            const bounds = [stone, baseline].map((i) => this.values.bound(i, turn, key));
            const bound = bounds.includes(null) || decimals === 0 ? null : bounds[0] + bounds[1];
            const cell = element('td', {}, signed(value - from, decimals), ...bounded(bound, decimals));
            // Stones may be alike in it, for all that is known.
            if (bound !== null && Math.abs(value - from) <= bound) cell.className = 'within';
            return cell;
        }

        /** Mark in a stone's row the band that is pointed at in its map; null for none. */
        mark(stone, band) {
            for (const cell of this.body.querySelectorAll('td.lit')) cell.classList.remove('lit');
            const row = find(this.body, `tr[data-stone="${stone}"]`);
            if (band !== null) row?.querySelector(`td[data-band="${band}"]`)?.classList.add('lit');
        }

        /** The table as the command line's CSV has it, every digit, with all turns of each stone. */
        download() {
            const { head, rows } = this.values.csv;
            const lines = [head, ...this.order().flatMap((stone) => rows[stone])];
            const file = new Blob([lines.map((line) => `${line}\r\n`).join('')], { type: 'text/csv' });
            const address = URL.createObjectURL(file);
            element('a', { href: address, download: 'gemrender-scores.csv' }).click();
            setTimeout(() => URL.revokeObjectURL(address), 1000);
        }
    }

    function bounded(bound, decimals) {
        return bound === null || decimals === 0 ? [] : [' ', element('small', {}, `±${boundText(bound)}`)];
    }

    const defineGroup = ({ name, definition, source, version }) => define(name, definition, `${source}. Version ${version}`);

    return Object.freeze({ Values, ScoreTable });
})();
