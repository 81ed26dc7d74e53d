// The map around the present stone: its score over crown and pavilion angle, filling in from coarse to fine.

import { find, inNextFrame, number, tip } from './shared.js';

/** viridis at even steps (Smith and van der Walt, 2015), dark to bright. */
const SCALE = ['#440154', '#46327e', '#365c8d', '#277f8e', '#1fa187', '#4ac16d', '#a0da39', '#fde725'];
const [COLUMN, ROW] = [1, 0];

export class Around {
    constructor(root, chosen) {
        Object.assign(this, { root, chosen });
        this.redraw = inNextFrame(() => this.draw());
        this.canvas = find(root, 'canvas');
        this.box = find(root, 'select');
        this.cells = new Map();
        this.at = null;
        this.cursor = { row: 0, column: 0 };
        this.box.addEventListener('change', () => this.draw());
        new ResizeObserver(() => this.draw()).observe(root);
        this.canvas.addEventListener('click', (event) => this.choose(this.cellAt(event)));
        this.canvas.addEventListener('pointermove', (event) => {
            const words = this.words(this.cellAt(event));
            if (words && event.pointerType !== 'touch') tip.show(event, words);
            else tip.hide();
        });
        this.canvas.addEventListener('pointerleave', () => tip.hide());
        this.canvas.addEventListener('keydown', (event) => this.press(event));
    }

    clear() {
        this.isStale = true;
        this.root.classList.add('stale');
    }

    add(message) {
        if (this.isStale) {
            this.cells.clear();
            this.isStale = false;
            this.cursor = { row: 0, column: 0 };
            this.root.classList.remove('stale');
        }
        this.root.hidden = false;
        this.at = message;
        for (const cell of message.cells) this.cells.set(`${cell[ROW]},${cell[COLUMN]}`, { cell, size: message.size });
        this.redraw();
    }

    cellAt(event) {
        if (!this.at) return null;
        const { left, top, width } = this.canvas.getBoundingClientRect();
        const count = 2 * this.at.steps + 1;
        const place = (share) => Math.min(Math.max(Math.floor(share * count), 0), count - 1) - this.at.steps;
        return { column: place((event.clientX - left) / width), row: -place((event.clientY - top) / width) };
    }

    angles({ row, column }) {
        const { crown, pavilion, step } = this.at;
        return { crown: crown + row * step, pavilion: pavilion + column * step };
    }

    words(place) {
        if (!place || !this.at) return '';
        const { crown, pavilion } = this.angles(place);
        const found = this.cells.get(`${place.row},${place.column}`)?.cell;
        const told = !found ? '' : found[2] === null ? ': no such stone' : `: Average ${number(found[2], 2)} %, Rear ${number(found[3], 2)} %`;
        return `Crown ${number(crown, 2)}°, pavilion ${number(pavilion, 2)}°${told}`;
    }

    choose(place) {
        if (!place || (place.row === 0 && place.column === 0)) return;
        const { crown, pavilion } = this.angles(place);
        this.chosen(Number(crown.toFixed(3)), Number(pavilion.toFixed(3)));
    }

    press(event) {
        const moves = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [1, 0], ArrowDown: [-1, 0] }[event.key];
        if (event.key === 'Enter') this.choose(this.cursor);
        else if (moves && this.at) {
            const inside = (n) => Math.min(Math.max(n, -this.at.steps), this.at.steps);
            this.cursor = { row: inside(this.cursor.row + moves[0]), column: inside(this.cursor.column + moves[1]) };
            this.draw();
            find(this.root, '.note').textContent = this.words(this.cursor);
        } else return;
        event.preventDefault();
    }

    draw() {
        const width = this.canvas.clientWidth;
        const ratio = window.devicePixelRatio || 1;
        const pixels = Math.max(Math.round(width * ratio), 1);
        if (this.canvas.width !== pixels) this.canvas.width = this.canvas.height = pixels;
        const context = this.canvas.getContext('2d');
        context.clearRect(0, 0, pixels, pixels);
        if (!this.at) return;
        const { steps } = this.at;
        const [side, of] = [pixels / (2 * steps + 1), Number(this.box.value)];
        const known = [...this.cells.values()].filter(({ cell }) => cell[of] !== null);
        const values = known.map(({ cell }) => cell[of]);
        const [low, high] = [Math.min(...values), Math.max(...values)];
        for (const { cell, size } of known.sort((a, b) => b.size - a.size)) {
            const share = high > low ? (cell[of] - low) / (high - low) : 0.5;
            context.fillStyle = SCALE[Math.min(Math.floor(share * SCALE.length), SCALE.length - 1)];
            const half = (size - 1) / 2;
            const [left, top] = [(cell[COLUMN] + steps - half) * side, (steps - cell[ROW] - half) * side];
            context.fillRect(Math.floor(left), Math.floor(top), Math.ceil(size * side) + 1, Math.ceil(size * side) + 1);
        }
        const mark = ({ row, column }, colour) => {
            for (const [style, line] of [['#000000', 4], [colour, 2]]) {
                context.strokeStyle = style;
                context.lineWidth = line * ratio;
                context.strokeRect((column + steps) * side, (steps - row) * side, side, side);
            }
        };
        mark({ row: 0, column: 0 }, '#ffffff');
        if (document.activeElement === this.canvas) mark(this.cursor, '#86b3ff');
        const { crown, pavilion, step } = this.at;
        const reach = steps * step;
        find(this.root, '.note').textContent =
            `${number(low, 1)} to ${number(high, 1)} %. Across: pavilion angle ${number(pavilion - reach, 1)}° to ${number(pavilion + reach, 1)}°; ` +
            `up: crown angle ${number(crown - reach, 1)}° to ${number(crown + reach, 1)}°. A click takes over both.`;
    }
}
