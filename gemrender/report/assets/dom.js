'use strict';

// Numbers in words, and elements of the page and of its drawings.

const GemDom = (() => {
    const number = (value, digits) => value.toFixed(digits).replace('-', '−');
    const find = (root, selector) => root.querySelector(selector);

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

    return Object.freeze({ number, find, element, drawing });
})();
