"""Exceptions and warnings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Finding:
    """One error of a scene.

    key:     "table.key", as in a scene file
    problem: what is wrong with it
    hint:    what was probably meant, or what to do; None where nothing is known
    source:  the file, and
    line, column: the place in it, from 1; "" and 0 for a scene that is no file, 0 for a file that does not exist
    """

    key: str
    problem: str
    hint: str | None = None
    source: str = ""
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        place = f"{self.source}:{self.line}:{self.column}: " if self.line else f"{self.source}: " if self.source else ""
        key = f"{self.key}: " if self.key else ""
        return f"{place}{key}{self.problem}" + (f"; {self.hint}" if self.hint else "")


class SceneError(ValueError):
    """A scene that cannot be run.

    findings: all its errors, each a Finding
    key, hint: those of the first one
    """

    def __init__(self, findings: list[Finding | tuple[str, int, int, str, str]]):
        self.findings: list[Finding] = []
        for one in findings:
            if not isinstance(one, Finding):
                source, line, column, key, message = one
                problem, _, hint = message.partition("; ")
                if source == "--set" or not source:  # a value of Python's own
                    source, line, column = "", 0, 0
                one = Finding(key, problem, hint or None, source, line, column)
            self.findings.append(one)
        super().__init__("\n".join(map(str, self.findings)))

    def __reduce__(self) -> Any:
        return type(self), (self.findings,)

    @property
    def key(self) -> str:
        return self.findings[0].key if self.findings else ""

    @property
    def hint(self) -> str | None:
        return self.findings[0].hint if self.findings else None


class IntegrationError(RuntimeError):
    """A run that failed. `result` is the viscobar.Result of the part that it reached, or None."""

    result: Any = None


class RunWarning(UserWarning):
    """What a run has to say about itself, such as chatter; also in Result.warnings."""
