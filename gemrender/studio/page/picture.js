// The picture: photoreal, in a set-up, rendered by another process while nothing moves; each pass shows what is there.

import { byId, data, element, find, number } from './shared.js';
import { download } from './files.js';

/** The set-up that pictures begin with. */
const FIRST = 'studio';
/** The metal of a setting, as `gemrender render` has it. */
const FIRST_METAL = 'platinum';

/** The words of the history. */
export const pictureWords = ({ setup, setting }) => `Picture in the set-up ${setup}${setting ? `, setting ${setting}` : ''}`;

export class Picture {
    /** `asked` is called with {setup, denoise}, and {setting, metal} of what holds it, where a picture is wanted, else with null. */
    constructor(root, asked) {
        Object.assign(this, {
            root, asked, box: byId('setup'), setting: byId('setting'), metal: find(byId('metal'), 'select'),
            button: byId('paint'), denoise: byId('denoise'), image: find(root, 'img'),
        });
        this.png = null;
        this.isWanted = false;
        const options = (values) => values.map((value) => element('option', { value }, value));
        this.box.append(...options(data.setups));
        this.setting.append(...options(data.settings));
        this.metal.append(...options(data.metals));
        this.box.value = FIRST;
        this.metal.value = FIRST_METAL;
        this.denoise.checked = data.hasDenoiser;
        const chosen = () => ({ setup: this.box.value, denoise: this.denoise.checked, ...this.held() });
        this.box.addEventListener('change', () => this.asked(chosen()));
        this.setting.addEventListener('change', () => this.asked(chosen()));
        this.metal.addEventListener('change', () => this.asked(chosen()));
        this.denoise.addEventListener('change', () => this.isWanted && this.asked(chosen()));
        this.button.addEventListener('click', () => this.asked(this.isWanted ? null : chosen()));
        byId('keep-picture').addEventListener('click', () => this.save());
    }

    /** What holds the stone, as a state has it. */
    held() {
        const setting = this.setting.value;
        if (!setting) return {};
        return setting === 'none' ? { setting } : { setting, metal: this.metal.value };
    }

    /** Show what of it is wanted, and that what is there is of another state, until it is told otherwise. */
    show(wanted, name) {
        this.isWanted = Boolean(wanted);
        this.name = name;
        if (wanted) {
            [this.box.value, this.denoise.checked] = [wanted.setup, Boolean(wanted.denoise)];
            this.setting.value = wanted.setting ?? '';
            if (wanted.metal) this.metal.value = wanted.metal;
        }
        byId('metal').hidden = !this.held().metal;
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
        const { setting = 'none', metal } = this.held();
        const held = setting === 'none' ? '' : `, ${metal} ${setting}`;
        const facts = `${title}, set-up ${this.box.value}${held}: ${samples} samples a pixel${within}${this.denoise.checked ? ', denoised' : ''}`;
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
