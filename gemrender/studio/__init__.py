"""The studio: a stone in the browser that answers while its sliders are dragged.

The engine in Python is the one truth. `cuttings` says what of a stone can be changed, `frames` what a page
shows of one, `studies` what is found out while nothing moves, `live` which of all that is worked at;
`protocol` makes messages of it, and `app` is the server, which nothing else here knows of.
"""

from __future__ import annotations
