// Messages as `gemrender.studio.protocol` has them; of states the newest only.

import { connect } from './channel.js';

const TYPES = {
    uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array, int32: Int32Array,
    float32: Float32Array, float64: Float64Array,
};

function unpack(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const arrays = {};
    for (const { name, type, shape, at } of header.arrays) {
        const count = shape.reduce((a, b) => a * b, 1);
        arrays[name] = new TYPES[type](buffer, 4 + length + at, count);
    }
    return { ...header, arrays };
}

export class Wire {
    /** `hear` has a function for each type of message, and `lost`, `found`, `theme`. */
    constructor(hear) {
        this.hear = hear;
        this.flying = null; // number of the state that is worked at
        this.waiting = null;
        this.channel = connect({
            opened: (wasLost) => {
                this.flying = null;
                this.hear.found(wasLost);
            },
            closed: () => {
                this.flying = null;
                this.hear.lost();
            },
            message: (buffer) => this.take(unpack(buffer)),
            theme: (isDark) => this.hear.theme(isDark),
        });
    }

    take(message) {
        if (message.number === this.flying && (message.type === 'frame' || message.type === 'refused')) {
            this.flying = null;
            if (this.waiting) {
                const next = this.waiting;
                this.waiting = null;
                this.want(next);
            }
        }
        this.hear[message.type]?.(message);
    }

    /** Ask for a state; while one is worked at, only the newest after it waits. */
    want(state) {
        if (!this.channel.isOpen) return;
        if (this.flying !== null) {
            this.waiting = state;
            return;
        }
        this.flying = state.number;
        this.channel.send(JSON.stringify({ type: 'state', ...state }));
    }

    ask(message) {
        if (this.channel.isOpen) this.channel.send(JSON.stringify(message));
    }

    /** Send a file's bytes behind their header. */
    send(header, bytes) {
        if (!this.channel.isOpen) return;
        const text = new TextEncoder().encode(JSON.stringify(header));
        const whole = new Uint8Array(4 + text.length + bytes.length);
        new DataView(whole.buffer).setUint32(0, text.length, true);
        whole.set(text, 4);
        whole.set(bytes, 4 + text.length);
        this.channel.send(whole);
    }
}
