// What the studio shares with the report, as a module: classic scripts there, as a page on disk needs them.
/* global GemDom, GemLight, GemPage, GemRay, GemStage, GemStone, GemTracer */

export const { number, find, element, drawing } = GemDom;
export const { data, cards, hear, announce } = GemPage;
export const Light = GemLight;
export const Ray = GemRay;
export const Tracer = GemTracer;
export const { geometryOf } = GemStone;
export const { Stage } = GemStage;

export const byId = (id) => document.getElementById(id);

/** A number with its sign, as differences are written. */
export const signed = (value, digits) => (value > 0 ? '+' : '') + number(value, digits);

/** A bound as it is told: two digits that count. */
export function boundText(bound) {
    if (!(bound > 0)) return '0';
    const digits = Math.min(Math.max(1 - Math.floor(Math.log10(bound)), 1), 6);
    return bound < 1e-4 ? '0.0001' : number(bound, digits);
}

/** What draws in the next frame of the screen, once however often it is called until then. */
export function inNextFrame(draw) {
    let isWaiting = false;
    return () => {
        if (isWaiting) return;
        isWaiting = true;
        requestAnimationFrame(() => {
            isWaiting = false;
            draw();
        });
    };
}

/** Words beside the pointer. */
export const tip = {
    box: byId('tip'),
    show(event, text) {
        this.box.textContent = text;
        this.box.hidden = false;
        const { width, height } = this.box.getBoundingClientRect();
        const left = Math.min(event.clientX + 14, document.documentElement.clientWidth - width - 6);
        this.box.style.left = `${left}px`;
        this.box.style.top = `${Math.max(event.clientY - height - 10, 4)}px`;
    },
    hide() {
        this.box.hidden = true;
    },
};
