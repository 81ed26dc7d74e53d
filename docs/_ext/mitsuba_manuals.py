"""The directives of Mitsuba's manual: `pluginparameters`, and `tabs` with `code-tab`.

They mean what they mean there (mitsuba.readthedocs.io): a table of parameters with their types and flags, and
one example in several languages.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.parsers.rst.directives.tables import ListTable
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx_design.tabs import TabItemDirective, TabSetDirective

_HEADS = ("Parameter", "Type", "Description", "Flags")
#: Widths of the columns [%].
_WIDTHS = (20, 11, 57, 12)
_LANGUAGES = {"xml": "XML", "python": "dict"}

#: What the manuals write short, as Mitsuba's own have it.
SHORT = "\n".join(
    f".. |{name}| replace:: {name}"
    for name in ("exposed", "differentiable", "bool", "float", "int", "string", "vector", "spectrum", "bsdf")
)


class PluginParameters(ListTable):
    """A list of parameters: name, type, description and, or not, flags."""

    def check_list_content(self, node: nodes.Element) -> tuple[int, Any]:
        """Fill short rows up with empty cells, as the last may be left out; put the heads on top."""
        listed = node[0] if node.children else None
        if isinstance(listed, nodes.bullet_list):
            head = nodes.bullet_list(
                "", *(nodes.list_item("", nodes.paragraph(text=name)) for name in _HEADS)
            )
            listed.insert(0, nodes.list_item("", head))
            for row in listed:
                cells = row[0]
                while isinstance(cells, nodes.bullet_list) and len(cells) < len(_HEADS):
                    cells += nodes.list_item()
                for name in cells[0].findall(nodes.Text) if row is not listed[0] else ():
                    name.parent.replace(name, nodes.literal(name, name))
        self.options |= {"header-rows": 1, "widths": list(_WIDTHS), "class": ["plugin-parameters"]}
        return super().check_list_content(node)


class Tabs(TabSetDirective):
    """Examples side by side; those of one language are chosen together."""


class CodeTab(TabItemDirective):
    """One of them: code in a language."""

    def run_with_defaults(self) -> list[nodes.Node]:
        """Return the tab, with its code highlighted."""
        language = self.arguments[0].strip()
        # Parts of a dictionary are no program: highlighted by force.
        code = [f".. code-block:: {language}", "   :force:", "", *(f"   {line}" for line in self.content)]
        self.content = StringList(code, source=self.content.source(0))
        self.arguments = [_LANGUAGES.get(language, language)]
        self.options = {"sync": language}
        return super().run_with_defaults()


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directives and the role."""
    app.add_directive("pluginparameters", PluginParameters)
    app.add_directive("tabs", Tabs)
    app.add_directive("code-tab", CodeTab)
    app.add_generic_role("monosp", nodes.literal)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
