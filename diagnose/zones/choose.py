"""Which zone table fits a machine and a sensor, and what was assumed to say so."""

from __future__ import annotations

from ...datasets.recording import Channel, Nameplate
from .table import ChosenTable, ZoneRow, find_table

# Housing channels are judged by rms, a displacement probe looks at the shaft.
_SENSOR_OF_QUANTITY = {"acceleration": "housing", "velocity": "housing", "displacement": "shaft"}


def fits(row: ZoneRow, channel: Channel) -> bool:
    """Whether a table row can judge a channel."""
    return channel.quantity is not None and _SENSOR_OF_QUANTITY.get(channel.quantity) == row.sensor


def automatic_table(channel: Channel, nameplate: Nameplate) -> ChosenTable:
    """Return the table for a channel of a machine for which the user named none.

    Shaft probes: ISO 14839-2 when a magnetic-bearing clearance is known, else the shaft formula of ISO
    20816-3. Housings: ISO 20816-3 by power or shaft height (group 1 over 300 kW or from 315 mm, group 2 from
    15 kW or 160 mm), below that ISO 10816-1 class I. When nothing is known, group 2 with rigid mounting, said
    to be an assumption.
    """
    if channel.quantity == "displacement":
        magnetic = nameplate.magnetic_bearing_clearance_m is not None
        return find_table("iso14839-2" if magnetic else "iso20816-3-shaft")
    power, height, mounting = nameplate.power_kw, nameplate.shaft_height_mm, nameplate.mounting
    if power is None and height is None:
        rows = find_table(f"iso20816-3-group2-{mounting or 'rigid'}").rows
        assumed = "group 2" if mounting else "group 2, rigid"
        return ChosenTable(rows, f"machine group not given: {assumed} assumed; pass --severity-table")
    if (power is not None and power > 300.0) or (height is not None and height >= 315.0):
        return find_table("iso20816-3-group1", mounting=mounting)
    if (power is not None and power >= 15.0) or (height is not None and height >= 160.0):
        return find_table("iso20816-3-group2", mounting=mounting)
    assumption = "" if power is not None else "shaft height under 160 mm and power not given: class I assumed"
    return ChosenTable(find_table("iso10816-1-class1").rows, assumption)
