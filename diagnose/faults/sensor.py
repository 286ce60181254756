"""Sensor and acquisition faults: clipping, dropouts, drift, a dead channel, a coarse range."""

from __future__ import annotations

from ..observe import Observation
from ..result import Finding


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return a sensor fault with the severity of the worst data check as its probability."""
    worst = max(now.checks, key=lambda check: check.severity, default=None)
    if worst is None or worst.severity < 0.35:
        return []
    text = " ".join(check.message for check in now.checks if check.severity >= 0.35)
    return [
        Finding(
            "sensor_fault",
            min(0.95, worst.severity),
            text,
            (),
            "Check cable, mounting, range and supply of the sensor.",
        )
    ]
