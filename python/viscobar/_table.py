"""Tables: lists of dictionaries that know how to show themselves."""

from __future__ import annotations

import html
from typing import Any


SHOWN = 30  # rows in a notebook


class Table(list):
    """Rows of a study: a list of dictionaries with the same keys.

    summary: what the program prints with --json, as a dictionary
    page:    a self-contained HTML page with the pictures, or None
    """

    def __init__(self, rows: Any = (), summary: dict[str, Any] | None = None, page: str | None = None):
        super().__init__(rows)
        self.summary = summary if summary is not None else {}
        self.page = page

    @property
    def columns(self) -> list[str]:
        """Keys of the rows, in order."""
        return list(dict.fromkeys(key for row in self for key in row))

    def column(self, key: str) -> list[Any]:
        """The values of one key, row by row."""
        return [row.get(key) for row in self]

    def frame(self) -> Any:
        """The rows as a pandas DataFrame. Needs pandas."""
        import pandas

        return pandas.DataFrame(list(self), columns=self.columns or None)

    def __str__(self) -> str:
        return text(self.columns, [[row.get(key) for key in self.columns] for row in self])

    def _repr_html_(self) -> str:
        """The first rows; the pictures are on `page`."""
        head = "".join(f"<th>{html.escape(key)}</th>" for key in self.columns)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell(row.get(key)))}</td>" for key in self.columns) + "</tr>" for row in self[:SHOWN]
        )
        more = f"<p>{len(self) - SHOWN} more rows</p>" if len(self) > SHOWN else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.6g}"
    return str(value)


def text(columns: list[str], rows: list[list[Any]]) -> str:
    cells = [columns] + [[cell(value) for value in row] for row in rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(columns))]
    return "\n".join("  ".join(value.rjust(width) for value, width in zip(row, widths)).rstrip() for row in cells)
