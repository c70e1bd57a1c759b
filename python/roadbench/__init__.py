"""roadbench: motorcycle tyre coefficients, with confidence intervals, from recorded riding logs.

Tables cross as Arrow, by the PyCapsule interface: whatever takes ``__arrow_c_stream__`` takes them,
and they share its memory.

Example:
    >>> import polars as pl, roadbench
    >>> session = roadbench.run_session("ride.parquet", bike="bikes/mt07.toml")
    >>> session.coefficients.filter(pl.col("status") == "ok")
    >>> session.plot()

Over whole archives: :func:`run` and :func:`diagnose`; on a Spark cluster :func:`roadbench.spark.run`. Their
tables as frames: :func:`read`; a session as a figure: :func:`plot`, as an interactive chart: :func:`chart`.

What a call acts on comes first and by position; all else goes by its name. What is refused is an :class:`Error`.
"""

from roadbench._archive import compare, diagnose, export, plan, run
from roadbench._chart import chart
from roadbench._commands import Verified, bike_new, forget, inspect, map, report, verify
from roadbench._errors import (
    Error,
    Internal,
    Invalid,
    InvalidType,
    NoOutput,
    NoTable,
    NotInstalled,
    OutputError,
    Rejected,
)
from roadbench._memory import Diagnosed, Simulated, diagnose_session, run_session, schema, simulate
from roadbench._plot import plot
from roadbench._progress import Progress
from roadbench._read import Tables, read
from roadbench._roadbench import Schema, Table, __version__
from roadbench._session import Session
from roadbench._types import Inspected, InspectedSource, Planned, Summary

__all__ = [
    "Diagnosed",
    "Error",
    "Inspected",
    "InspectedSource",
    "Internal",
    "Invalid",
    "InvalidType",
    "NoOutput",
    "NoTable",
    "NotInstalled",
    "OutputError",
    "Planned",
    "Progress",
    "Rejected",
    "Schema",
    "Session",
    "Simulated",
    "Summary",
    "Table",
    "Tables",
    "Verified",
    "__version__",
    "bike_new",
    "chart",
    "compare",
    "diagnose",
    "diagnose_session",
    "export",
    "forget",
    "inspect",
    "map",
    "plan",
    "plot",
    "read",
    "report",
    "run",
    "run_session",
    "schema",
    "simulate",
    "verify",
]
