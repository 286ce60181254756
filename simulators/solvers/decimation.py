"""Anti-aliased decimation, block by block: the simulated sensor's converter.

Without it every acceleration line above half the output rate folds back: with a mesh at 690 Hz sampled at 30 kHz,
onto every multiple of 30 Hz.
"""

from __future__ import annotations

import numpy as np

#: Output frequencies up to this share of the output rate are passed; 0.6 and above is stopped, so that nothing folds
#: back below 0.4.
PASSED = 0.4
STOP_ATTENUATION_DB = 100.0


def filter_half_length(factor: int) -> int:
    """Return how many input samples the filter needs on each side of an output sample.

    A whole number of output samples (Kaiser's formula), so that a run starts at the same time whatever its step.
    """
    width = 2 * np.pi * (1 - 2 * PASSED)
    return factor * int(np.ceil((STOP_ATTENUATION_DB - 8) / (2.285 * width) / 2))


class Decimator:
    """Linear-phase low-pass and decimation by ``factor`` of blocks (samples, channels).

    Output sample k is centred on input sample k x factor + half length.
    """

    def __init__(self, factor: int) -> None:
        from scipy.signal.windows import kaiser

        self.factor = factor
        self.half = filter_half_length(factor)
        beta = 0.1102 * (STOP_ATTENUATION_DB - 8.7)
        ideal = np.sinc(np.arange(-self.half, self.half + 1) / factor)
        taps = ideal * kaiser(2 * self.half + 1, beta)
        self.taps = taps / taps.sum()
        self._kept: np.ndarray | None = None

    def __call__(self, block: np.ndarray) -> np.ndarray:
        """Return the output samples that this further block completes, shape (samples, channels)."""
        from scipy.signal import upfirdn

        held = block if self._kept is None else np.concatenate([self._kept, block])
        width = self.taps.size
        count = max(0, (held.shape[0] - width) // self.factor + 1)
        self._kept = held[count * self.factor :].copy()
        if count == 0:
            return np.zeros((0, held.shape[1]))
        used = held[: (count - 1) * self.factor + width]
        # upfirdn's output starts width - 1 samples before the first full overlap; shift so that one falls on it.
        lead = (-(width - 1)) % self.factor
        padded = np.concatenate([np.zeros((lead, used.shape[1])), used]) if lead else used
        filtered = upfirdn(self.taps, padded, up=1, down=self.factor, axis=0)
        first = (width - 1 + lead) // self.factor
        return filtered[first : first + count]
