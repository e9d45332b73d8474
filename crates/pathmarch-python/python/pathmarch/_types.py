"""Exceptions and small values of the package."""

from __future__ import annotations

import os
from typing import Any, NamedTuple, Optional, Sequence, Tuple

Range = Tuple[Optional[float], Optional[float]]


class Diagnostic(NamedTuple):
    """A mistake or a warning, with its place in the text of a scene."""

    message: str
    """One sentence: what is wrong."""
    line: int
    """Line of its start, from 1."""
    column: int
    """Column of its start, from 1, in characters."""
    length: int
    """Number of characters that it marks."""
    file: str
    """Path of the file, or name of the text."""
    code: str
    """Stable name, as in "pathmarch::unknown_node"."""
    label: str
    """What is wrong with the marked text."""
    help: Optional[str]
    """What to do."""


class Parameter(NamedTuple):
    """A number that the text of a scene declares by `param`."""

    name: str
    value: float
    range: Range
    """Smallest and largest value; None without a limit."""
    doc: Optional[str]
    animated: bool
    """True if the value depends on the time."""


class SceneError(ValueError):
    """A text that is no scene. Its text is the report of all mistakes.

    >>> import pathmarch
    >>> try:
    ...     pathmarch.Scene("pathmarch 1\\ncamera { position 0 1 4; target 0 0 0 }\\nobject ball { shpere 1 }")
    ... except pathmarch.SceneError as error:
    ...     print(error.positions, error.diagnostics[0].help)
    [(3, 15)] Did you mean `sphere`?
    """

    def __init__(self, report: str, diagnostics: Sequence[Diagnostic] = ()) -> None:
        super().__init__(report, tuple(diagnostics))

    @property
    def diagnostics(self) -> Tuple[Diagnostic, ...]:
        """Every mistake, in the order of the text; none if a file cannot be read."""
        return self.args[1]

    @property
    def positions(self) -> list[tuple[int, int]]:
        """Line and column of every mistake."""
        return [(diagnostic.line, diagnostic.column) for diagnostic in self.diagnostics]

    def __str__(self) -> str:
        return self.args[0]


class SceneWarning(UserWarning):
    """What a scene may have, but most likely should not."""


class RenderError(RuntimeError):
    """A backend that is missing, or has failed."""


class Cancelled(Exception):
    """Work that was ended because its progress callback returned False."""

    def __init__(self, samples: int = 0, picture: Any = None) -> None:
        super().__init__(samples, picture)

    @property
    def samples(self) -> int:
        """Number of samples that were done."""
        return self.args[0]

    @property
    def picture(self) -> Any:
        """The picture of these samples; None without any."""
        return self.args[1]

    def __str__(self) -> str:
        return f"cancelled after {self.samples} samples"


def restored_scene(text: str, name: str, time: float, allow_files: bool) -> Any:
    """Scene of a pickle."""
    from . import Scene

    return Scene(text, time=time, folder=os.path.dirname(name), allow_files=allow_files)
