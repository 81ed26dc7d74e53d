'use strict';

// What pages are made of: numbers in words, elements, and what is said beside the pointer, in a dialog and aloud.

const GemDom = (() => {
    /** Smallest bound that is told, as the command line does. */
    const LEAST_BOUND = 1e-4;
    /** Only what things come to rest at is said aloud [ms]. */
    const SAID_AFTER = 350;

    const number = (value, digits) => value.toFixed(digits).replace('-', '−');
    const find = (root, selector) => root.querySelector(selector);

    /** A number with its sign, as differences are written. */
    const signed = (value, digits) => (value > 0 ? '+' : '') + number(value, digits);

    /** A bound with two digits, rounded up, so that what is stated is true. */
    function boundText(bound) {
        const least = Math.max(bound, LEAST_BOUND);
        const decimals = 1 - Math.floor(Math.log10(least));
        const step = 10 ** -decimals;
        const text = (Math.ceil((least / step) * (1 - 1e-12)) * step).toFixed(Math.max(decimals, 0));
        return text.includes('.') ? text.replace(/\.?0+$/, '') : text;
    }

    /** A definition as print has it. */
    const typeset = (text) => text[0].toUpperCase() + text.slice(1).replace(/`([^`]*)`/g, '“$1”').replaceAll(' - ', ' − ');

    function element(name, properties = {}, ...children) {
        const made = Object.assign(document.createElement(name), properties);
        made.append(...children);
        return made;
    }

    function drawing(name, attributes = {}, ...children) {
        const made = document.createElementNS('http://www.w3.org/2000/svg', name);
        for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
        made.append(...children);
        return made;
    }

    /** What draws in the next frame of the screen, once however often it is called until then. */
    function inNextFrame(draw) {
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
    const tip = {
        get box() {
            return document.getElementById('tip');
        },
        show(event, text) {
            const { box } = this;
            box.textContent = text;
            box.hidden = false;
            const { width, height } = box.getBoundingClientRect();
            const left = Math.min(event.clientX + 14, document.documentElement.clientWidth - width - 6);
            box.style.left = `${left}px`;
            box.style.top = `${Math.max(event.clientY - height - 10, 4)}px`;
        },
        hide() {
            this.box.hidden = true;
        },
    };

    let announcing = 0;
    function announce(text) {
        clearTimeout(announcing);
        announcing = setTimeout(() => {
            document.getElementById('announce').textContent = text;
        }, SAID_AFTER);
    }

    /** Show what a measure is, and where it comes from, in a dialog that is made when it is first asked for. */
    function define(name, definition, source) {
        let dialog = document.getElementById('definition');
        if (!dialog) {
            const close = element('form', { method: 'dialog' }, element('button', {}, 'Close'));
            dialog = element('dialog', { id: 'definition' },
                element('h2', { id: 'defined' }), element('p', { className: 'words' }), element('p', { className: 'source' }), close,
            );
            dialog.setAttribute('aria-labelledby', 'defined');
            document.body.append(dialog);
        }
        find(dialog, 'h2').textContent = name;
        find(dialog, '.words').textContent = `${typeset(definition)}.`;
        find(dialog, '.source').textContent = `Source: ${source}.`;
        dialog.showModal();
    }

    return Object.freeze({
        number, find, signed, boundText, typeset, element, drawing, inNextFrame, tip, announce, define,
    });
})();
