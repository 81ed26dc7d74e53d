'use strict';

// What the report's scripts know of their page (`GemPage`), as the studio is one: the data it was opened with, and its
// one stone. A classic script, as those are; `shared.js` hands them all on to modules.

const GemPage = (() => {
    const data = JSON.parse(document.getElementById('data').textContent);
    const cards = [];
    const hear = { choose: () => {} };
    return Object.freeze({
        data,
        cards,
        hear,
        choose: (point) => hear.choose(point),
    });
})();
