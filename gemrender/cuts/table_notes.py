"""What there is to be told of a table of stones, in a few lines for however many rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from gemrender.cuts.columns import Columns
from gemrender.cuts.laboratory import OWN, Assumed
from gemrender.cuts.size import WEIGHT_TOLERANCE
from gemrender.cuts.table_rows import TableRow

__all__ = ["TableNotes"]

#: Different girdles and the like that a note tells apart.
_KINDS_LISTED = 3


class TableNotes:
    """What there is to be told of the rows of a table, counted."""

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, str, str]] = Counter()
        self.used: set[str] = set()
        # Of each family in how many rows parameters were taken as its own, and which.
        self._own_rows: Counter[str] = Counter()
        self._own: dict[str, Counter[str]] = {}
        self._passed_over: Counter[str] = Counter()
        self._rows_passed_over = 0
        self._weights: list[int] = []

    def count(self, assumed: Iterable[Assumed]) -> None:
        """Count what was assumed of a stone."""
        self._counts.update(map(_kind, assumed))

    def of_fancy(self, number: int, family: str, row: TableRow) -> None:
        """Count what was assumed of a row's stone, what was passed over, a weight that differs."""
        assert row.report is not None
        own = [one for one in row.report.assumed if _is_of_family(one)]
        self.count(one for one in row.report.assumed if one not in own)
        if own:
            self._own_rows[family] += 1
            self._own.setdefault(family, Counter()).update(f"{one.what} {one.told}" for one in own)
        self._passed_over.update(row.report.passed_over)
        self._rows_passed_over += bool(row.report.passed_over)
        if row.notes:
            self._weights.append(number)

    def notes(self, columns: Columns, rows: int) -> Iterator[str]:
        """Return the notes: a few, of however many rows."""
        used = {columns.others[key] for key in self.used if key in columns.others}
        titles = {columns.title[key] for key, place in columns.others.items() if place in used}
        if unused := [title for title in columns.unused if title not in titles]:
            yield f"columns not used: {', '.join(unused)}"
        yield from _assumed(self._counts, rows)
        for family, number in self._own_rows.most_common():
            own = ", ".join(
                words if count == number else f"{words} in {count} of them"
                for words, count in self._own[family].items()
            )
            yield f"assumed in {number} of {rows} rows: {family}: {own} {OWN}"
        if self._rows_passed_over:
            keys = ", ".join(key.replace("_", " ") for key, _ in self._passed_over.most_common())
            some = f"{self._rows_passed_over} of {rows} rows"
            yield f"not used in {some}, whose shapes have no such part: {keys}"
        if self._weights:
            share = f"{WEIGHT_TOLERANCE:.0%}".replace("%", " %")
            yield (
                f"weights differ by more than {share} from what shape and millimetres make in "
                f"{len(self._weights)} of {rows} rows, first in row {self._weights[0]}"
            )


def _is_of_family(assumed: Assumed) -> bool:
    """Whether it is a parameter of a family, taken as the family has it."""
    return isinstance(assumed.value, str)


def _kind(assumed: Assumed) -> tuple[str, str, str]:
    """Return an assumption's name, its value where that is the same in every row, and the reason."""
    derived = assumed.why.startswith("(depth")
    return assumed.what, "" if derived else assumed.told, assumed.why


def _assumed(counts: Counter[tuple[str, str, str]], rows: int) -> Iterator[str]:
    """Say what was assumed in how many rows: a note a kind, unless there are many."""
    by_name: dict[str, list[tuple[str, int]]] = {}
    for (what, value, why), number in counts.most_common():
        words = " ".join(part for part in (what, value, why) if part)
        together = f"{what} {'of words' if why.startswith('of') else why}"
        by_name.setdefault(together, []).append((words, number))
    for together, kinds in by_name.items():
        if len(kinds) <= _KINDS_LISTED:
            yield from (f"assumed in {number} of {rows} rows: {words}" for words, number in kinds)
        else:
            yield f"assumed in {sum(number for _, number in kinds)} of {rows} rows: {together}"
