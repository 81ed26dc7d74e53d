// The websocket: messages as `gemrender.studio.protocol` has them, the newest state only, and a server that went away.

const TYPES = {
    uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array, int32: Int32Array,
    float32: Float32Array, float64: Float64Array,
};
/** Waits between tries to reach the server again [ms]; the last one again and again. */
const WAITS = [300, 600, 1200, 2500, 5000];

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
    /** `hear` has a function for each type of message, and `lost`, `found`. */
    constructor(hear) {
        this.hear = hear;
        this.tries = 0;
        this.flying = null; // number of the state that is worked at
        this.waiting = null;
        this.connect();
    }

    connect() {
        const address = new URL('live', location.href);
        address.protocol = address.protocol.replace('http', 'ws');
        address.hash = '';
        this.socket = new WebSocket(address);
        this.socket.binaryType = 'arraybuffer';
        this.socket.addEventListener('open', () => {
            const wasLost = this.tries > 0;
            this.tries = 0;
            this.flying = null;
            this.hear.found(wasLost);
        });
        this.socket.addEventListener('message', ({ data }) => this.take(unpack(data)));
        this.socket.addEventListener('close', () => {
            this.flying = null;
            this.hear.lost();
            setTimeout(() => this.connect(), WAITS[Math.min(this.tries++, WAITS.length - 1)]);
        });
    }

    get isOpen() {
        return this.socket.readyState === WebSocket.OPEN;
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
        if (!this.isOpen) return;
        if (this.flying !== null) {
            this.waiting = state;
            return;
        }
        this.flying = state.number;
        this.socket.send(JSON.stringify({ type: 'state', ...state }));
    }

    ask(message) {
        if (this.isOpen) this.socket.send(JSON.stringify(message));
    }

    /** Send a file's bytes behind their header. */
    send(header, bytes) {
        if (!this.isOpen) return;
        const text = new TextEncoder().encode(JSON.stringify(header));
        const whole = new Uint8Array(4 + text.length + bytes.length);
        new DataView(whole.buffer).setUint32(0, text.length, true);
        whole.set(text, 4);
        whole.set(bytes, 4 + text.length);
        this.socket.send(whole);
    }
}
