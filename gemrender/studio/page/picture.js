// The picture: photoreal, in a set-up, rendered by another process while nothing moves; each pass shows what is there.

import { byId, data, element, find, number } from './shared.js';
import { download } from './files.js';

/** The set-up that pictures begin with. */
const FIRST = 'studio';

export class Picture {
    /** `asked` is called with {setup, denoise} where a picture is wanted, else with null. */
    constructor(root, asked) {
        Object.assign(this, { root, asked, box: byId('setup'), button: byId('paint'), denoise: byId('denoise'), image: find(root, 'img') });
        this.png = null;
        this.isWanted = false;
        this.box.append(...data.setups.map((value) => element('option', { value }, value)));
        this.box.value = FIRST;
        this.denoise.checked = data.hasDenoiser;
        const chosen = () => ({ setup: this.box.value, denoise: this.denoise.checked });
        this.box.addEventListener('change', () => this.asked(chosen()));
        this.denoise.addEventListener('change', () => this.isWanted && this.asked(chosen()));
        this.button.addEventListener('click', () => this.asked(this.isWanted ? null : chosen()));
        byId('keep-picture').addEventListener('click', () => this.save());
    }

    /** Show what of it is wanted, and that what is there is of another state, until it is told otherwise. */
    show(wanted, name) {
        this.isWanted = Boolean(wanted);
        this.name = name;
        if (wanted) [this.box.value, this.denoise.checked] = [wanted.setup, Boolean(wanted.denoise)];
        this.button.setAttribute('aria-pressed', String(this.isWanted));
        this.image.hidden = !this.isWanted || !this.png;
        this.root.classList.add('stale');
        find(this.root, 'progress').hidden = true;
        find(this.root, '.refused').hidden = true;
        if (this.isWanted && !this.png) this.tell('It begins as soon as nothing moves; the first one takes some seconds.');
    }

    add({ title, samples, noise, share, isDone, arrays }) {
        this.png = new Blob([arrays.png], { type: 'image/png' });
        const before = this.image.src;
        this.image.src = URL.createObjectURL(this.png);
        if (before) URL.revokeObjectURL(before);
        this.image.hidden = false;
        this.root.classList.remove('stale');
        byId('keep-picture').disabled = false;
        const progress = find(this.root, 'progress');
        progress.hidden = isDone;
        progress.value = share;
        const within = noise === null ? '' : `, noise ${number(100 * noise, noise < 0.1 ? 1 : 0)} %`;
        const facts = `${title}, set-up ${this.box.value}: ${samples} samples a pixel${within}${this.denoise.checked ? ', denoised' : ''}`;
        this.image.alt = facts;
        this.tell(`${facts}.`);
        this.root.dataset.samples = String(samples);
    }

    refuse(why) {
        find(this.root, '.refused').textContent = why;
        find(this.root, '.refused').hidden = false;
        find(this.root, 'progress').hidden = true;
    }

    save() {
        if (this.png) download(`${this.name.replace(/[^\w.-]+/g, '-')}-${this.box.value}.png`, [this.png], 'image/png');
    }

    tell(text) {
        find(this.root, '.note').textContent = text;
    }
}
