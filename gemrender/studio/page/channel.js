// What carries messages between the page and Python: a websocket, or, where the page is a frame within a notebook, the
// port that the notebook's widget hands it.

import { data } from './shared.js';

/** Waits between tries to reach the server again [ms]; the last one again and again. */
const WAITS = [300, 600, 1200, 2500, 5000];

/** Hears `opened(wasLost)`, `closed()` and `message(buffer)`; reconnects by itself. */
class Socket {
    constructor(hear) {
        this.hear = hear;
        this.tries = 0;
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
            this.hear.opened(wasLost);
        });
        this.socket.addEventListener('message', ({ data: message }) => this.hear.message(message));
        this.socket.addEventListener('close', () => {
            this.hear.closed();
            setTimeout(() => this.connect(), WAITS[Math.min(this.tries++, WAITS.length - 1)]);
        });
    }

    get isOpen() {
        return this.socket.readyState === WebSocket.OPEN;
    }

    send(message) {
        this.socket.send(message);
    }
}

/** As `Socket`; hears `theme(isDark)` too, which is the notebook's. */
class Port {
    constructor(hear) {
        this.isOpen = false;
        window.addEventListener('message', ({ source, ports: [port] }) => {
            if (source !== window.parent || !port) return;
            this.port = port;
            port.onmessage = ({ data: message }) => {
                if (message instanceof ArrayBuffer) hear.message(message);
                else if ('isDark' in message) hear.theme(message.isDark);
                else {
                    this.isOpen = message.isOpen;
                    if (this.isOpen) hear.opened(false);
                    else hear.closed();
                }
            };
        });
    }

    send(message) {
        this.port.postMessage(message);
    }
}

export const connect = (hear) => (data.isEmbedded ? new Port(hear) : new Socket(hear));
