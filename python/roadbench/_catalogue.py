"""What people read on the plots of the table ``plots``, as on the pages of the report (``src/report/plots``)."""

from __future__ import annotations

import math
from typing import NamedTuple


class Axis(NamedTuple):
    """A quantity, the unit it is shown in, and the factor from SI to it."""

    label: str
    unit: str = ""
    scale: float = 1.0

    def __str__(self) -> str:
        return f"{self.label} ({self.unit})" if self.unit else self.label


class Plot(NamedTuple):
    """A plot of a session."""

    title: str
    x: Axis
    y: Axis
    colour: Axis | None = Axis("wheel load", "N")
    turns_back: bool = False
    equal_scales: bool = False
    from_zero: bool = False


class Panel(NamedTuple):
    """A panel of the time line, and its series with their labels."""

    axis: Axis
    series: dict[str, str]


def _degrees(label: str) -> Axis:
    return Axis(label, "°", math.degrees(1.0))


_G = 1.0 / 9.80665
_CAMBER, _ROLL, _ALPHA = _degrees("camber"), _degrees("roll"), _degrees("slip angle")
_MU_X, _MU_Y = Axis("longitudinal friction Fx/Fz"), Axis("lateral friction Fy/Fz")
_SPEED, _LATERAL = Axis("speed", "m/s"), Axis("lateral acceleration", "g", _G)

# of a tyre: the names in the table end in _front and _rear
_OF_A_TYRE = {
    "friction_x": Plot("longitudinal friction", Axis("slip ratio"), _MU_X),
    "friction_y_slip": Plot("lateral friction over slip angle", _ALPHA, _MU_Y, turns_back=True),
    "slip_angle": Plot("slip angle", _CAMBER, _ALPHA),
    "friction_y": Plot("lateral friction over camber", _CAMBER, _MU_Y),
    "stiffness": Plot("stiffness", _CAMBER, Axis("stiffness per load", "1/rad"), from_zero=True),
}

PLOTS: dict[str, Plot] = {
    f"{name}_{tyre}": plot._replace(title=f"{tyre.capitalize()} · {plot.title}")
    for name, plot in _OF_A_TYRE.items()
    for tyre in ("front", "rear")
} | {
    "coast_down": Plot(
        "Coast-down", Axis("speed squared", "m²/s²"), Axis("resisting force", "N"), colour=None
    ),
    "overturning": Plot("Overturning", _ROLL, Axis("overturning arm Mx/(m g)", "mm", 1000.0), colour=None),
    "g_g": Plot("g-g diagram", _LATERAL, Axis("forward acceleration", "g", _G), _SPEED, equal_scales=True),
    "roll_over_lateral": Plot("Roll over lateral acceleration", _LATERAL, _ROLL, _SPEED),
}
"""By their names in the table, in the order of a session's page."""

COVARIATES = {
    "speed": _SPEED,
    "load": Axis("wheel load", "N"),
    "camber": _CAMBER,
    "temperature": Axis("temperature", "°C"),
    "time": Axis("time", "s"),
}
"""What residuals are drawn over."""

SERIES = {
    "fit": "fit",
    "k_alpha": "cornering kα",
    "k_gamma": "camber kγ",
    "balance": "thin tyres, steady",
    "trend": "trend",
}
"""Lines of the plots, in the legend."""


def _sides(name: str) -> dict[str, str]:
    return {f"{name}_{side}": side for side in ("front", "rear")}


def _riders(name: str) -> dict[str, str]:
    return {f"{name}_none": "no rider"} | {f"{name}_{r}": f"rider {r.upper()}" for r in "abc"}


PANELS = [
    Panel(_SPEED, {"velocity_x": "speed"}),
    Panel(Axis("acceleration", "m/s²"), {"acceleration_x": "forward", "acceleration_y": "lateral"}),
    Panel(_ROLL, {"roll": "roll"}),
    Panel(_degrees("yaw rate")._replace(unit="°/s"), {"yaw_rate": "yaw rate"}),
    Panel(_degrees("steering angle"), {"steer_angle": "steering angle"}),
    Panel(Axis("brake pressure", "bar", 1e-5), _sides("brake_pressure")),
    Panel(Axis("throttle", "%", 100.0), {"throttle": "throttle"}),
    Panel(Axis("slip ratio"), _sides("slip_ratio")),
    Panel(Axis("tyre temperature", "°C"), _sides("tyre_temperature")),
    Panel(Axis("tyre pressure", "bar", 1e-5), _sides("tyre_pressure")),
    Panel(Axis("steering torque", "N m"), {"steer_torque": "steering torque"}),
    Panel(_degrees("pitch, nose up"), {"pitch_up": "pitch up"}),
    Panel(Axis("travel", "mm", 1000.0), {"fork_travel": "fork", "shock_travel": "shock"}),
    Panel(Axis("front load", "N"), _riders("load_front")),
    Panel(Axis("rear load", "N"), _riders("load_rear")),
    Panel(Axis("front along the chassis", "N"), _riders("along_front")),
    Panel(Axis("rear along the chassis", "N"), _riders("along_rear")),
    Panel(Axis("rider on the pegs, down", "N"), _riders("legs")),
    Panel(Axis("rider on the bar, forward", "N"), _riders("arms")),
]
"""Of the time line."""
