'use strict';

// What the report's scripts know of their page (`GemPage`), as the studio is one: the data it was opened with, its
// one stone, and what is said aloud. A classic script, as those are; `shared.js` hands them all on to modules.

const GemPage = (() => {
    const data = JSON.parse(document.getElementById('data').textContent);
    const cards = [];
    const hear = { choose: () => {} };
    let announcing = 0;
    return Object.freeze({
        data,
        cards,
        hear,
        choose: (point) => hear.choose(point),
        announce(text) {
            clearTimeout(announcing); // only what things come to rest at
            announcing = setTimeout(() => {
                document.getElementById('announce').textContent = text;
            }, 500);
        },
    });
})();
