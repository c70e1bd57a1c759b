"""Types that several functions take or give back."""

import os
from collections.abc import Sequence
from typing import Any, Literal, NotRequired, TypedDict

Path = str | os.PathLike[str]
Paths = Path | Sequence[Path]
Tyre = Literal["front", "rear"]
TextFormat = Literal["tir", "toml", "csv", "c", "tydex", "simulator"]
Format = Literal["tir", "toml", "csv", "c", "fmu", "tydex", "simulator"]
CoefficientSet = Literal["5.2", "6.2", "reduced"]


class Summary(TypedDict):
    """What :func:`roadbench.run` or :func:`roadbench.diagnose` did; ``run.json`` says the same of a run."""

    version: str
    """The roadbench."""
    started: str
    """When it began, UTC."""
    seconds: float
    """How long it took."""
    inputs: int
    """Logs found."""
    computed: int
    """Sessions computed."""
    unchanged: int
    """Sessions that were there already."""
    rejected: int
    """Logs that could not be used."""
    left: int
    """Logs that were not begun because the run was stopped."""
    bytes: int
    """Size of the logs."""
    rejected_by_code: dict[str, int]
    requests: NotRequired[dict[str, int]]
    """To object stores, where there were any."""
    pipeline_hash: NotRequired[str]
    pipeline: NotRequired[dict[str, Any]]
    """The stages' settings. A diagnosis with a progress bar has neither these nor their hash."""


class InspectedSession(TypedDict):
    """The session in a log."""

    session_id: str
    bike_id: str
    start_time: str | None
    tyre_front: str | None
    tyre_rear: str | None
    site: str | None
    rider_id: str | None
    duration: float
    """s"""
    rate: float
    """Hz"""
    samples: int
    distance: float | None
    """m"""
    bike_file: str | None


class InspectedChannel(TypedDict):
    """A channel of a log, in the unit it names."""

    channel: str
    unit: str
    rate: float | None
    """Hz"""
    samples: int
    missing: float
    """Share of samples, 0 to 1."""
    gaps: int
    longest_gap: float
    """s"""
    min: float | None
    median: float | None
    max: float | None
    verdict: str


class InspectedWarning(TypedDict):
    """What is odd about a log."""

    code: str
    channel: str | None
    count: int
    time: float | None
    """s"""
    message: str


class InspectedReason(TypedDict):
    """Why a log cannot be used."""

    code: str
    message: str


class InspectedEstimate(TypedDict):
    """Coefficients that a log can give or not."""

    tyre: str
    coefficients: list[str]
    status: str
    missing_channels: list[str]
    riding: str


class Inspected(TypedDict):
    """What :func:`roadbench.inspect` finds in a log."""

    session: InspectedSession
    channels: list[InspectedChannel]
    warnings: list[InspectedWarning]
    rejected: InspectedReason | None
    estimates: list[InspectedEstimate]
    costs: list[str]
    """What the bike file leaves open, and how much wider that makes intervals."""


class SourceChannel(TypedDict):
    """A channel as the log itself names it."""

    group: str
    name: str
    unit: str | None
    rate: float | None
    """Hz"""
    samples: int
    missing: int
    gaps: int
    longest_gap: float
    """s"""
    min: float | None
    median: float | None
    max: float | None


class InspectedSource(TypedDict):
    """What :func:`roadbench.inspect` finds in a log that no channel map fits."""

    format: str
    facts: list[list[str]]
    channels: list[SourceChannel]
    warnings: list[list[str]]
    proposed_map: str
    """TOML, ready to save."""


class PlannedInterval(TypedDict):
    """Half width of a 95 % interval over the value."""

    half_width: float | None
    """``None`` where the ride does not bound it."""
    status: str


class PlannedSideForce(TypedDict):
    """A coefficient of the side forces."""

    tyre: str
    coefficient: str
    ratio_given: bool
    planned: PlannedInterval
    with_slalom: PlannedInterval


class PlannedEffect(TypedDict):
    """A cause, and the smallest size that the ride shows half of the time."""

    effect: str
    limit: float | None
    unit: str
    limit_usual: float | None
    """Limit over the typical size; above 4: not detectable."""
    base: str | None
    base_cosine: float | None
    set: str | None
    limit_after: float | None


class PlannedPair(TypedDict):
    """Two causes that the ride can hardly tell apart."""

    pair: list[str]
    cosine: float
    separation: float
    set: str | None
    cosine_after: float | None
    separation_after: float | None


class Planned(TypedDict):
    """What :func:`roadbench.plan` predicts."""

    scenario: str
    duration: float | None
    """s; ``None`` of a scenario of the nonlinear motorcycle."""
    side_forces: list[PlannedSideForce]
    effects: list[PlannedEffect]
    pairs: list[PlannedPair]
