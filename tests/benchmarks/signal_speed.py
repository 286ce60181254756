"""Signal processing against openconmo, tsfel and rota-order, against one real FFT, and cost over length and channels.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/signal_speed.py [FOLDER]

The peers are installed with pip into a virtual environment in FOLDER (a temporary one when left out) and run there,
by `signal_peers.py`, on the same signals in the same run: ours, theirs, ours, theirs. Process CPU time, smallest of
several calls after a first one that compiles; every row has the error of both against the truth of its signal. Draws
docs/signal_cost.png.
"""

import json
import shutil
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

import numpy as np
from rotorwise.datasets.recording import Channel, MountedBearing, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose.features import features
from rotorwise.diagnose.observe import observe
from rotorwise.diagnose.signal.blind_sidebands import find_families
from rotorwise.diagnose.signal.cepstrum import band_cepstrum
from rotorwise.diagnose.signal.denoise import wavelet_denoise
from rotorwise.diagnose.signal.envelope import squared_envelope_spectrum
from rotorwise.diagnose.signal.integrate import band_velocity
from rotorwise.diagnose.signal.kurtogram import fast_kurtogram
from rotorwise.diagnose.signal.order_map import order_map
from rotorwise.diagnose.signal.spectrum import spectrum_with_floor
from rotorwise.diagnose.signal.speed_track import track_speed
from rotorwise.diagnose.signal.synchronous_average import synchronous_average
from rotorwise.diagnose.signal.vold_kalman import order_waveforms
from rotorwise.diagnose.signal.whitening import prewhiten, separate
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing

PEERS = ("openconmo==0.0.6", "tsfel==0.2.0", "rota-order==0.3.0")
HERE = Path(__file__).resolve().parent
PICTURE = HERE.parents[1] / "docs" / "signal_cost.png"
RUN_UP_RATE, IMPACT_RATE = 10_000, 25_600
ORDERS = ((1.0, 1.0), (2.0, 0.5), (3.5, 0.3))
REPEATS = 5
RNG = np.random.default_rng


def run_up(seed: int, *, noise: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return 9.8 s of a run-up from 10 to 50 Hz, and its speed: six orders through a resonance at 120 Hz, noise."""
    from scipy.signal import lfilter

    rng, time_s = RNG(seed), np.arange(98_000) / RUN_UP_RATE
    speed = 10 + 40 * time_s / time_s[-1] if seed % 2 else 30 - 20 * np.cos(np.pi * time_s / time_s[-1])
    angle = np.cumsum(speed) / RUN_UP_RATE
    lines = sum(rng.uniform(0.2, 1) * np.cos(2 * np.pi * (order * angle + rng.uniform())) for order in range(1, 7))
    pole = 0.995
    rung = lfilter([1 - pole], [1, -2 * pole * np.cos(2 * np.pi * 120 / RUN_UP_RATE), pole**2], lines)
    signal = lines / lines.std() + rung / rung.std()
    return signal / signal.std() + rng.normal(0, noise, speed.size), speed


def made_signals() -> dict[str, np.ndarray]:
    """Return every signal of the comparison with its truth, by name."""
    time_s = np.arange(98_000) / RUN_UP_RATE
    speed = 10 + 40 * time_s / time_s[-1]
    angle = np.cumsum(speed) / RUN_UP_RATE
    orders = sum(a * np.cos(2 * np.pi * order * angle) for order, a in ORDERS)
    found = {"orders": orders + RNG(0).normal(0, 0.1, angle.size), "clean": orders, "angle": angle, "speed": speed}
    for seed in range(6):
        found[f"run{seed}"], found[f"speed{seed}"] = run_up(seed)
    time_s = np.arange(10 * IMPACT_RATE) / IMPACT_RATE
    ring = np.exp(-800 * (time_s % 0.0123)) * np.sin(2 * np.pi * 7000 * (time_s % 0.0123))
    found["impacts"] = ring + RNG(1).normal(0, 0.3, time_s.size)
    found["lines"] = sum(np.cos(2 * np.pi * f * time_s) for f in (50.3, 100.6, 777.77, 2000.1))
    found["lines and noise"] = found["lines"] + RNG(2).normal(0, 1, time_s.size)
    found["second"] = found["impacts"][:IMPACT_RATE] + np.cos(2 * np.pi * 25 * time_s[:IMPACT_RATE])
    return found


def cpu_seconds(work, repeats: int = REPEATS) -> float:
    """Return the smallest process CPU time of a call, after one that is not counted."""
    work()
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def ours(signals: dict[str, np.ndarray]) -> dict[str, dict]:
    """Return our time and error for each task; the keys are those of `signal_peers.py`."""
    angle, rate = signals["angle"], RUN_UP_RATE
    follow = {"rate_hz": rate, "phase_turns": angle}

    def mapped():
        return order_map(signals["orders"], highest_order=10, turns_a_frame=4, turns_a_step=1, **follow)

    def waves():
        return order_waveforms(signals["orders"], orders=[o for o, _ in ORDERS], bandwidth_hz=1.0, **follow)

    def tracked(number: int):
        return track_speed(signals[f"run{number}"], rate_hz=rate, lowest_hz=5.0, highest_hz=4000 / 60)

    found = mapped()
    map_error = worst_decibels(np.abs(found.amplitude[0]), found.orders)
    wave = waves()
    wave_error = [
        20 * np.log10(np.abs(row[5000:-5000]) / a) for row, (_, a) in zip(wave.envelope[0], ORDERS, strict=True)
    ]
    left = wave.residual[0] - (signals["orders"] - signals["clean"])
    tracks = [tracked(number) for number in range(6)]
    wrong = np.concatenate(
        [
            np.abs(one.speed_hz / np.interp(one.time_s * rate, np.arange(angle.size), signals[f"speed{i}"]) - 1)
            for i, one in enumerate(tracks)
        ]
    )
    impacts = fast_kurtogram(signals["impacts"], rate_hz=IMPACT_RATE)
    lines = separate(signals["lines and noise"], segment_samples=16384)[0]
    recording, count = one_second(signals["second"])
    return {
        "order map": {"s": cpu_seconds(mapped), "error": f"{map_error:.3f} dB"},
        "Vold-Kalman, 3 orders": {
            "s": cpu_seconds(waves),
            "error": f"{np.abs(wave_error).max():.2f} dB, rest {decibels(left, signals['clean']):.0f} dB",
        },
        "speed from vibration": {
            "s": cpu_seconds(lambda: tracked(0)),
            "error": f"median {np.median(wrong):.1e}, {(wrong < 0.03).mean():.1%} within 3 %",
        },
        "kurtogram": {
            "s": cpu_seconds(lambda: fast_kurtogram(signals["impacts"], rate_hz=IMPACT_RATE)),
            "error": f"{impacts.low_hz[impacts.best]:.0f}-{impacts.high_hz[impacts.best]:.0f} Hz",
        },
        "deterministic and random": {
            "s": cpu_seconds(lambda: separate(signals["lines and noise"], segment_samples=16384)),
            "error": f"{decibels(lines - signals['lines'], signals['lines']):.1f} dB",
        },
        "features of 1 s": {"s": cpu_seconds(lambda: features(observe(recording))), "error": f"{count} features"},
    }


def worst_decibels(amplitude: np.ndarray, axis: np.ndarray) -> float:
    """Return the worst error of the known orders over all frames of a map."""
    return max(
        float(np.abs(20 * np.log10(amplitude[:, int(np.argmin(np.abs(axis - order)))] / a)).max())
        for order, a in ORDERS
    )


def decibels(rest: np.ndarray, whole: np.ndarray) -> float:
    """Return the rms of one signal over that of another, without the ends."""
    return 20 * float(np.log10(rest[5000:-5000].std() / whole[5000:-5000].std()))


def one_second(signal: np.ndarray) -> tuple[Recording, int]:
    """Return one second of one channel of a machine with a bearing, and how many features it has."""
    plate = Nameplate(bearings=(MountedBearing(find_bearing("6205")),))
    channel = (Channel("a", "acceleration"),)
    recording = Recording(signal[None], float(IMPACT_RATE), channel, OperatingCondition(1500.0), plate)
    return recording, int(np.isfinite(list(features(observe(recording)).values())).sum())


def against_fft(signals: dict[str, np.ndarray]) -> list[tuple[str, float]]:
    """Return the time of each function over that of one real FFT of the same 10 s at 25.6 kHz."""
    x, rate = signals["lines and noise"], float(IMPACT_RATE)
    phase = np.arange(x.size) * (25.0 / rate) + 1e-5 * np.sin(np.arange(x.size) * 1e-4)
    floor = {"highest_line_hz": 500.0, "floor_width_hz": 25.0}
    spectrum = spectrum_with_floor(x, rate_hz=rate, floor_width_hz=25.0)
    tasks = {
        "spectrum with floor": lambda: spectrum_with_floor(x, rate_hz=rate, floor_width_hz=25.0),
        "velocity, 10-1000 Hz": lambda: band_velocity(
            x, rate_hz=rate, quantity="acceleration", low_hz=10.0, high_hz=1000.0
        ),
        "wavelet denoising": lambda: wavelet_denoise(x),
        "prewhitening": lambda: prewhiten(x),
        "squared envelope spectrum": lambda: squared_envelope_spectrum(
            x, rate_hz=rate, low_hz=6e3, high_hz=8e3, **floor
        ),
        "kurtogram": lambda: fast_kurtogram(x, rate_hz=rate),
        "deterministic and random": lambda: separate(x, segment_samples=16384),
        "cepstrum": lambda: band_cepstrum(x, rate_hz=rate, low_hz=200.0, high_hz=10000.0, narrowest_hz=5.0),
        "blind sidebands": lambda: find_families(spectrum, channel=0, narrowest_hz=5.0, widest_hz=100.0),
        "order map to 20X": lambda: order_map(x, rate_hz=rate, phase_turns=phase, highest_order=20),
        "synchronous average to 100X": lambda: synchronous_average(x, phase_turns=phase, highest_order=100),
        "Vold-Kalman, 3 orders": lambda: order_waveforms(
            x, rate_hz=rate, phase_turns=phase, orders=[1, 2, 3], bandwidth_hz=1.0
        ),
        "speed from vibration": lambda: track_speed(x, rate_hz=rate, lowest_hz=10.0, highest_hz=60.0),
    }
    unit = cpu_seconds(lambda: np.fft.rfft(x), repeats=20)
    print(f"\none real FFT of 10 s at 25.6 kHz: {1e3 * unit:.2f} ms")
    return [(name, cpu_seconds(work) / unit) for name, work in tasks.items()]


def growth() -> dict[str, dict[str, tuple[list[float], list[float]]]]:
    """Return CPU seconds over record length (s, one channel) and over channels (4 s) at 25.6 kHz."""

    def cost(name: str, seconds: float, channels: int) -> float:
        x = RNG(3).normal(size=(channels, int(seconds * IMPACT_RATE)))
        phase = np.arange(x.shape[1]) * (25.0 / IMPACT_RATE)
        options = {"rate_hz": float(IMPACT_RATE)}
        work = {
            "spectrum with floor": lambda: spectrum_with_floor(x, floor_width_hz=25.0, **options),
            "kurtogram": lambda: [fast_kurtogram(row, **options) for row in x],
            "order map": lambda: order_map(x, phase_turns=phase, highest_order=20, **options),
            "Vold-Kalman, 3 orders": lambda: order_waveforms(
                x, phase_turns=phase, orders=[1, 2, 3], bandwidth_hz=1.0, **options
            ),
            "speed from vibration": lambda: track_speed(x, lowest_hz=10.0, highest_hz=60.0, **options),
        }[name]
        return cpu_seconds(work, repeats=3)

    names = ("spectrum with floor", "kurtogram", "order map", "Vold-Kalman, 3 orders", "speed from vibration")
    lengths, channels = [1, 2, 4, 8, 16, 32], [1, 2, 4, 8, 16]
    return {
        "Record length (s)": {name: (lengths, [cost(name, one, 1) for one in lengths]) for name in names},
        "Channels": {name: (channels, [cost(name, 4, one) for one in channels]) for name in names},
    }


def draw(panels: dict[str, dict[str, tuple[list[float], list[float]]]]) -> None:
    """Draw both panels of `growth` with plotly and chromium."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=1, cols=2, horizontal_spacing=0.12)
    colours = ("#1f6fb2", "#b5482a", "#2f8f4e", "#7a4fa3", "#8a6d1f")
    for column, (title, curves) in enumerate(panels.items(), start=1):
        for colour, (name, (x, y)) in zip(colours, curves.items(), strict=True):
            look = {"color": colour}
            figure.add_trace(
                go.Scatter(x=x, y=y, name=name, line=look, mode="lines+markers", showlegend=column == 1),
                row=1,
                col=column,
            )
        figure.update_xaxes(type="log", title=title, tickvals=x, row=1, col=column)
        figure.update_yaxes(type="log", title="CPU time (s)", exponentformat="power", dtick=1, row=1, col=column)
    figure.update_layout(
        width=1000, height=430, template="plotly_white", margin={"l": 70, "r": 20, "t": 60, "b": 60},
        legend={"orientation": "h", "y": 1.02, "yanchor": "bottom"},
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "cost.html"
        figure.write_html(page, include_plotlyjs=True, config={"displayModeBar": False})
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"]
        options += [f"--user-data-dir={folder}", "--window-size=1010,440", f"--screenshot={PICTURE}"]
        subprocess.run(
            [shutil.which("chromium") or "chromium", *options, page.as_uri()], check=True, capture_output=True
        )
    print(f"drawn: {PICTURE}")


def peers_python(folder: Path) -> Path:
    """Return the Python of an environment with the peers, made when it is not there."""
    python = folder / "bin" / "python"
    if not python.exists():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *PEERS], check=True)
    return python


def main() -> None:
    """Compare, print, draw."""
    with tempfile.TemporaryDirectory() as made:
        python = peers_python(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(made) / "peers")
        signals = made_signals()
        file = Path(made) / "signals.npz"
        np.savez(file, **signals)
        rounds = []
        for _ in range(2):
            own = ours(signals)
            answer = subprocess.run(
                [python, HERE / "signal_peers.py", file], check=True, capture_output=True, text=True
            ).stdout
            rounds.append((own, json.loads(answer.splitlines()[-1])))
    print("| task | ours, s | theirs, s | ratio | our error | their error | peer |\n|---|---|---|---|---|---|---|")
    for task, own in rounds[0][0].items():
        mine = min(one[task]["s"] for one, _ in rounds)
        theirs = min(other[task]["s"] for _, other in rounds)
        peer = rounds[0][1][task]
        words = f"{theirs / mine:.1f} | {own['error']} | {peer['error']} | {peer['peer']}"
        print(f"| {task} | {mine:.4f} | {theirs:.3f} | {words} |")
    ratios = against_fft(signals)
    print("\n| function | over one real FFT |\n|---|---|")
    for name, ratio in ratios:
        print(f"| {name} | {ratio:.1f} |")
    draw(growth())


if __name__ == "__main__":
    main()
