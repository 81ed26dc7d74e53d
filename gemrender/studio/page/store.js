// What is shown, its history, and the link that holds all of it.

/** Most steps that can be undone. */
const MOST_STEPS = 200;

const clone = (value) => JSON.parse(JSON.stringify(value));

async function through(stream, bytes) {
    return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

export async function encoded(value) {
    const bytes = await through(new CompressionStream('deflate-raw'), new TextEncoder().encode(JSON.stringify(value)));
    let text = '';
    for (const byte of bytes) text += String.fromCharCode(byte);
    return btoa(text).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

export async function decoded(text) {
    const letters = atob(text.replaceAll('-', '+').replaceAll('_', '/'));
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    return JSON.parse(new TextDecoder().decode(await through(new DecompressionStream('deflate-raw'), bytes)));
}

export class Store {
    /** `changed` is called with the state whenever there is a new one. */
    constructor(changed) {
        this.changed = changed;
        this.state = null;
        this.sliders = [];
        this.baseline = null; // {state, sliders, score}
        this.steps = [];
        this.place = -1;
        this.count = 0;
    }

    /** Change what is shown; with words it is a step of the history, without one it is on its way there. */
    set(change, words = null) {
        Object.assign(this.state, change);
        if (words !== null) this.keep(words);
        this.tell();
    }

    /** Show another stone. */
    open(state, sliders, words) {
        this.state = state;
        this.sliders = sliders;
        this.keep(words);
        this.tell(true);
    }

    tell(isOther = false) {
        this.state.number = ++this.count;
        this.changed(this.state, isOther);
        this.writeLink();
    }

    // ---- History ----

    keep(words) {
        const { number: _, ...state } = clone(this.state);
        const text = JSON.stringify(state);
        if (this.place >= 0 && this.steps[this.place].text === text) return;
        this.steps.length = this.place + 1;
        this.steps.push({ text, sliders: this.sliders, words });
        if (this.steps.length > MOST_STEPS) this.steps.shift();
        this.place = this.steps.length - 1;
    }

    go(place) {
        if (place < 0 || place >= this.steps.length || place === this.place) return;
        this.place = place;
        this.show(this.steps[place]);
    }

    show({ text, sliders }) {
        this.state = JSON.parse(text);
        this.sliders = sliders;
        this.tell(true);
    }

    undo() {
        this.go(this.place - 1);
    }

    redo() {
        this.go(this.place + 1);
    }

    // ---- The link ----

    get whole() {
        const { number: _, ...state } = this.state;
        return { state, baseline: this.baseline ? JSON.parse(this.baseline.text) : null };
    }

    writeLink() {
        clearTimeout(this.writing);
        this.writing = setTimeout(async () => {
            try {
                history.replaceState(null, '', `#${await encoded(this.whole)}`);
            } catch {
                // A browser that allows few changes in a while: the page goes on without.
            }
        }, 400);
    }

    static async readLink() {
        if (location.hash.length < 2) return null;
        try {
            const { state, baseline } = await decoded(location.hash.slice(1));
            return state?.cut ? { state, baseline } : null;
        } catch {
            return null; // what makes no sense there is left out
        }
    }
}
