"""``rotorwise orders``: amplitudes of shaft orders over the run, the order map, waveforms, orbits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError
from . import cli_options as options
from .cli_options import option
from .look_options import AsJson, File, Force, Request, SpeedRange, Start, Stop, speed_range_hz

if TYPE_CHECKING:
    from .look import Answer, Looked

_MOST_ORDERS = 12

OrderList = Annotated[str, option("--orders", value="LIST", text="Orders to follow: 0.5,1,2,3. Left out: 1,2,3.")]
HighestOrder = Annotated[
    float, option("--highest-order", value="NUMBER", text="Of the order map, or the highest of --orders. Left out: 10.")
]
Bandwidth = Annotated[
    float | None,
    option("--bandwidth", value="HZ", text="Of the order filters. Left out: 0.15 of the lowest speed."),
]


def orders(
    file: File,
    follow: OrderList = "1,2,3",
    highest_order: HighestOrder = 10.0,
    bandwidth: Bandwidth = None,
    speed_range: SpeedRange = None,
    start: Start = 0.0,
    stop: Stop = None,
    speed: options.Speed = None,
    tacho: options.Tacho = None,
    pulses_per_revolution: options.Pulses = None,
    rate: options.Rate = None,
    unit: options.Unit = None,
    sensitivity: options.Sensitivity = None,
    channel_name: options.ChannelName = None,
    direction: options.Direction = None,
    skip: options.Skip = None,
    sidecar: options.Sidecar = None,
    report: options.Report = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Show the shaft orders of a recording: amplitude and phase over the run, order map, orbits.

    The speed comes from the tacho, else from the vibration.
    """
    record = options.record_metadata(rate, speed, tacho, pulses_per_revolution)
    channels = options.channel_metadata(unit, sensitivity, channel_name, direction, skip)
    wanted, limits = order_list(follow), speed_range_hz(speed_range)
    if not 1 <= highest_order <= 1000:
        raise InvalidValueError(f"Highest order {highest_order}; allowed: 1 to 1000.")
    request = Request(file, record.merged_over(channels), sidecar, report, as_json, force, start, stop)

    def work(looked: Looked) -> Answer:
        from .orders import measure
        from .report.orders_page import answer

        found = measure(looked, wanted, highest_order=highest_order, bandwidth_hz=bandwidth, range_hz=limits)
        return answer(request.file.name, looked, found)

    from .look import carry_out
    from .orders import MEMORY

    raise typer.Exit(carry_out(request, work, need=MEMORY))


def order_list(text: str) -> tuple[float, ...]:
    """Return orders given as ``0.5,1,2``.

    Raises
    ------
    InvalidValueError
        For text that is no such list.
    """
    try:
        found = tuple(dict.fromkeys(float(part) for part in text.split(",") if part.strip()))
    except ValueError:
        found = ()
    if not found or len(found) > _MOST_ORDERS or not all(0 < order <= 1000 for order in found):
        raise InvalidValueError(
            f"Orders {text!r}; allowed: 1 to {_MOST_ORDERS} numbers above 0, up to 1000. Write 0.5,1,2."
        )
    return found
