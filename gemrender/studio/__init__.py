"""The studio: a stone in the browser that answers while its sliders are dragged.

The engine in Python is the one truth. `cuttings` says what of a stone can be changed, `frames` what a page
shows of one, `studies` what is found out while nothing moves, `pictures` (with the process `painter`) what is
rendered then, `live` which of all that is worked at; `protocol` makes messages of it, and a `session` is one
page. Two carry its messages, which nothing else here knows of: `app`, the server, and `widget`, in notebooks.
"""

from __future__ import annotations
