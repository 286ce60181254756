"""The peers' half of `signal_speed.py`: the same tasks on the same signals, through their public functions.

    python signal_peers.py SIGNALS.npz          in an environment with openconmo, tsfel and rota-order

Prints one line of JSON: seconds of process CPU time and error by task.
"""

import json
import sys
import time
import warnings

import numpy as np
import rota
import tsfel
from openconmo.benchmark_methods import DRS
from openconmo.kurtogram import fast_kurtogram

RUN_UP_RATE, IMPACT_RATE = 10_000, 25_600
ORDERS = ((1.0, 1.0), (2.0, 0.5), (3.5, 0.3))


def cpu_seconds(work, repeats=3):
    """Return the smallest process CPU time of a call, after one that is not counted."""
    work()
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def rota_order(signals):
    """Return the three tasks of order tracking; the speed is given as it is."""
    x, rpm = signals["orders"], 60 * signals["speed"]

    def mapped():
        return rota.maps.rpm_order_map(x, RUN_UP_RATE, rpm, order_resolution=0.25, max_order=10, amplitude="peak")

    def waves():
        # Its bandwidth is one-sided.
        return rota.extract.order_waveform(x, RUN_UP_RATE, rpm, [order for order, _ in ORDERS], bandwidth=0.5)

    def tracked(number):
        return rota.speed.rpm_from_ridge(signals[f"run{number}"], RUN_UP_RATE, (300, 4000))

    found = mapped()
    values = np.asarray(found.values)
    values = values if values.shape[-1] == np.size(found.axis) else values.T
    worst = max(
        float(np.abs(20 * np.log10(values[:, int(np.argmin(np.abs(found.axis - order)))] / a)).max())
        for order, a in ORDERS
    )
    wave = waves()
    error = [20 * np.log10(np.abs(wave.envelopes[5000:-5000, k]) / a) for k, (_, a) in enumerate(ORDERS)]
    noise = x - signals["clean"]
    left = x - wave.waveforms.sum(axis=1) - noise
    rest = 20 * np.log10(left[5000:-5000].std() / signals["clean"][5000:-5000].std())
    wrong = []
    for number in range(6):
        one = tracked(number)
        truth = np.interp(one.t * RUN_UP_RATE, np.arange(rpm.size), signals[f"speed{number}"])
        wrong.append(np.abs(one.rpm / 60 / truth - 1))
    wrong = np.concatenate(wrong)
    within = (wrong < 0.03).mean()
    return {
        "order map": {"s": cpu_seconds(mapped), "error": f"{worst:.3f} dB"},
        "Vold-Kalman, 3 orders": {
            "s": cpu_seconds(waves),
            "error": f"{np.abs(error).max():.2f} dB, rest {rest:.0f} dB",
        },
        "speed from vibration": {
            "s": cpu_seconds(lambda: tracked(0)),
            "error": f"median {np.median(wrong):.1e}, {within:.1%} within 3 %",
        },
    }


def openconmo(signals):
    """Return the two tasks of impact detection."""

    def kurtogram():
        return fast_kurtogram(signals["impacts"], IMPACT_RATE, nlevel=7)

    def separated():
        return DRS(signals["lines and noise"], 16384, 16384)

    *_, centre, width = kurtogram()
    lines = signals["lines"]
    _, found = separated()
    count = min(np.size(found), lines.size)
    # Its filter may delay: the best of all shifts up to a segment is taken.
    spectrum = np.fft.rfft(lines[:count]).conj() * np.fft.rfft(np.asarray(found)[:count])
    shift = int(np.argmax(np.fft.irfft(spectrum, n=count)))
    rest = np.roll(np.asarray(found)[:count], -shift) - lines[:count]
    inner = slice(40_000, -40_000)
    error = 20 * np.log10(rest[inner].std() / lines[:count][inner].std())
    return {
        "kurtogram": {"s": cpu_seconds(kurtogram), "error": f"{centre - width / 2:.0f}-{centre + width / 2:.0f} Hz"},
        "deterministic and random": {"s": cpu_seconds(separated), "error": f"{error:.1f} dB"},
    }


def tsfel_features(signals):
    """Return the time of all features of tsfel on one second."""
    chosen = tsfel.get_features_by_domain()

    def extract():
        return tsfel.time_series_features_extractor(chosen, signals["second"], fs=IMPACT_RATE, verbose=0)

    count = np.shape(extract())[1]
    return {"features of 1 s": {"s": cpu_seconds(extract), "error": f"{count} features"}}


def main():
    """Run all tasks."""
    warnings.simplefilter("ignore")
    signals = dict(np.load(sys.argv[1]))
    answer = {}
    for name, work in (("rota-order", rota_order), ("openconmo", openconmo), ("tsfel", tsfel_features)):
        answer |= {task: one | {"peer": name} for task, one in work(signals).items()}
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
