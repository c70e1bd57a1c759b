"""A session in words: what was found first, then what was not, and why."""

from __future__ import annotations

import math
from html import escape
from typing import TYPE_CHECKING, Any

from roadbench._frames import rows

if TYPE_CHECKING:
    from roadbench._session import Session

Row = dict[str, Any]
_PARTS = ("front", "rear", "vehicle")
_HEADS = ("tyre", "coefficient", "symbol", "value", "95 % interval", "unit")
_NOT_OK = {
    "poorly_determined": "poorly determined",
    "lower_bound": "only a lower bound",
    "not_determined": "not determined",
    "assumed": "assumed, not from this ride",
}


def line(session: Session) -> str:
    """On one line."""
    return f"{session.id} of {session.bike}: {_counts(session)}"


def _counts(session: Session) -> str:
    """How much was found."""
    found = rows(session["coefficients"]) if "coefficients" in session else []
    warned = len(rows(session["warnings"])) if "warnings" in session else 0
    determined = sum(row["status"] == "ok" for row in found)
    of_all = f"{determined} of {len(found)} coefficients ok" if found else "no coefficients"
    return f"{of_all}, {warned} warning{'' if warned == 1 else 's'}"


def session(session: Session) -> str:
    """For notebooks; no script, nothing from elsewhere."""
    found = rows(session["coefficients"]) if "coefficients" in session else []
    # an output of `diagnose` alone has no table `sessions`
    ride = f"; {_ride(session)}" if "sessions" in session else ""
    parts = [f"<h4>{escape(session.id)} · {escape(session.bike)}</h4>", f"<p><b>{_counts(session)}</b>{ride}</p>"]
    determined = [row for row in found if row["status"] == "ok"]
    if determined:
        parts.append(_table(_HEADS, [_cells(row) for row in _in_order(determined)]))
    for status in dict.fromkeys(row["status"] for row in found if row["status"] != "ok"):
        of_status = [row for row in _in_order(found) if row["status"] == status]
        words = _NOT_OK.get(status, status.replace("_", " "))
        lines = [[*_cells(row), row["reason"] or "", row["advice"] or ""] for row in of_status]
        parts.append(_folded(f"{len(of_status)} {words}", _table((*_HEADS, "reason", "advice"), lines)))
    if warned := rows(session["warnings"]) if "warnings" in session else []:
        lines = [[row["code"], row["channel"] or "", row["message"]] for row in warned]
        words = f"{len(warned)} warning{'' if len(warned) == 1 else 's'}"
        parts.append(_folded(words, _table(("code", "channel", "message"), lines)))
    return "".join(parts)


def _ride(session: Session) -> str:
    """The ride in a few words."""
    info = session.info
    facts = [f"{info['n_used']} of {info['n_manoeuvres']} manoeuvres used", f"{info['duration']:.0f} s"]
    if info["distance"] is not None:
        facts.append(f"{info['distance'] / 1000:.1f} km")
    if info["start_time"] is not None:
        facts.append(f"{info['start_time']:%Y-%m-%d %H:%M} UTC")
    facts += [f"{tyre} {info[f'tyre_{tyre}']}" for tyre in ("front", "rear") if info[f"tyre_{tyre}"]]
    return escape(", ".join(facts))


def _in_order(found: list[Row]) -> list[Row]:
    """By tyre; within one as the table has them."""
    place = {part: number for number, part in enumerate(_PARTS)}
    return sorted(found, key=lambda row: place.get(row["tyre"], len(place)))


def _cells(row: Row) -> list[str]:
    low, high = row["ci95_low"], row["ci95_high"]
    value = "" if row["value"] is None else number(row["value"], low, high)
    ends = [("" if end is None else number(end, low, high)) for end in (low, high)]
    between = " to ".join(ends) if all(ends) else f"at least {ends[0]}" if ends[0] else f"at most {ends[1]}" if ends[1] else ""
    unit = "" if row["unit"] == "1" else row["unit"]
    return [row["tyre"], row["coefficient"], row["symbol"], value, between, unit]


def number(value: float, low: float | None, high: float | None) -> str:
    """With as many digits as its interval tells: two of the half width."""
    half = 0.0 if low is None or high is None else (high - low) / 2
    if not math.isfinite(value) or not math.isfinite(half) or half <= 0.0:
        return f"{value:.4g}"
    return f"{value:.{min(max(0, 1 - math.floor(math.log10(half))), 9)}f}"


def _table(heads: tuple[str, ...], body: list[list[str]]) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    lines = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in body)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table>"


def _folded(summary: str, inside: str) -> str:
    return f"<details><summary>{escape(summary)}</summary>{inside}</details>"
