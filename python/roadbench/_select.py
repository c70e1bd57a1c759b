"""Which sessions of an output are wanted, and the files that hold them.

A table of sessions has a file per motorcycle and month (``coefficients/bike=b1/2026-05.parquet``). The table
``sessions`` has the same files, and says by its rows which of them a session is in.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import NamedTuple
from urllib.parse import unquote

from roadbench._errors import Invalid, NoTable
from roadbench._folders import Folder, Where
from roadbench._frames import Frames

_INDEX = ("sessions", "diagnoses", "coefficients")
"""Tables that have rows of every session; the first that is there says which there are. The last is an archive's truth."""
_CUT = 100
"""Names of files as long as this may be cut: then they don't say whose they are."""
_SHOWN = 8


class Place(NamedTuple):
    """Where a session is."""

    session: str
    bike: str
    part: str
    """``bike=...``, as the folder is called."""
    stem: str
    """Month, or what else the file is called."""


class Selection(NamedTuple):
    """Sessions and motorcycles that are wanted; ``None`` takes all."""

    sessions: tuple[str, ...] | None = None
    bikes: tuple[str, ...] | None = None

    @property
    def where(self) -> Where:
        """The same as texts of columns."""
        wanted = {"session_id": self.sessions, "bike_id": self.bikes}
        return {column: texts for column, texts in wanted.items() if texts is not None}

    def places(self, folder: Folder, frames: Frames) -> list[Place]:
        """Where the wanted sessions are.

        Raises:
            Invalid: there is no such session or motorcycle.
        """
        files = self._index(folder)
        found = [
            Place(session, bike, *_parts(file))
            for session, bike, file in folder.places(files, frames)
            if self.bikes is None or bike in self.bikes
        ]
        if self.bikes is not None:
            there = {place.bike for place in found}
            known = there if there >= set(self.bikes) else {b for _, b, _ in folder.places(self._all(folder), frames)}
            _all_known("motorcycle", self.bikes, known)
        if self.sessions is None:
            return found
        wanted = set(self.sessions)
        _all_known("session", self.sessions, {place.session for place in found}, self.bikes)
        return [place for place in found if place.session in wanted]

    def _index(self, folder: Folder) -> list[str]:
        """The files that say which sessions there are: of the wanted motorcycles, where their names say so."""
        files = self._all(folder)
        return [file for file in files if self._of_bikes(_parts(file)[0])] or files

    def _all(self, folder: Folder) -> list[str]:
        for name in _INDEX:
            if files := folder.files(name):
                return files
        raise NoTable(f"there is no table `{_INDEX[0]}`, which says what sessions there are; `roadbench.run` writes it")

    def _of_bikes(self, part: str) -> bool:
        if self.bikes is None or not part or len(part) >= _CUT:
            return True
        return unquote(part.removeprefix("bike=")) in self.bikes

    def files(self, files: list[str], folder: Folder, frames: Frames) -> list[str]:
        """Of a table's files those that may have what is wanted; one that has its columns where none does."""
        if self == Selection():
            return files
        kept = [file for file in files if self._of_bikes(_parts(file)[0])]
        if self.sessions is not None:
            places = {(place.part, place.stem) for place in self.places(folder, frames)}
            kept = [file for file in kept if self._of_sessions(*_parts(file), places)]
        return kept or [next((file for file in files if "/bike=_none/" in file.replace("\\", "/")), files[0])]

    def _of_sessions(self, part: str, stem: str, places: set[tuple[str, str]]) -> bool:
        if not part:
            return True  # a table over the whole fleet
        # signals have a file per session
        return (part, stem) in places or len(stem) >= _CUT or unquote(stem) in (self.sessions or ())


def selection(sessions: str | Iterable[str] | None, bike: str | Iterable[str] | None) -> Selection:
    """As it was given to :func:`roadbench.read`."""

    def several(given: str | Iterable[str] | None) -> tuple[str, ...] | None:
        if given is None:
            return None
        return (given,) if isinstance(given, str) else tuple(given)

    return Selection(several(sessions), several(bike))


def _parts(file: str) -> tuple[str, str]:
    """Folder of the motorcycle, empty where there is none, and the file's name without its ending."""
    parts = file.replace("\\", "/").split("/")
    part = parts[-2] if len(parts) > 1 and parts[-2].startswith("bike=") else ""
    return part, parts[-1].removesuffix(".parquet")


def _all_known(kind: str, wanted: Iterable[str], known: set[str], bikes: Sequence[str] | None = None) -> None:
    for one in wanted:
        if one not in known:
            of = f" of {' or '.join(bikes)}" if bikes else ""
            raise Invalid(f"there is no {kind} `{one}`{of}; {_near(one, sorted(known))}")


def _near(word: str, known: Sequence[str]) -> str:
    """What was meant, or what there is."""
    folded = word.casefold()
    held = [one for one in known if folded and folded in one.casefold()]
    near = held[:1] or difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    if near:
        return f"did you mean `{near[0]}`?"
    more = ", ..." if len(known) > _SHOWN else ""
    return f"there are {', '.join(known[:_SHOWN]) or 'none'}{more}"
