"""Anti-aliased decimation, block by block: the simulated sensor's converter.

Without it every acceleration line above half the output rate folds back: with a mesh at 690 Hz sampled at 30 kHz,
onto every multiple of 30 Hz.
"""

from __future__ import annotations

import numpy as np

from .layout import ROWS

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

    Output sample k is centred on input sample k x factor + half length. Each is summed in the same order, so that
    neither other channels nor the length of the blocks change its bits.
    """

    def __init__(self, factor: int) -> None:
        self.factor = factor
        self.half = filter_half_length(factor)
        ideal = np.sinc(np.arange(-self.half, self.half + 1) / factor)
        taps = ideal * np.kaiser(2 * self.half + 1, 0.1102 * (STOP_ATTENUATION_DB - 8.7))
        self.taps = taps / taps.sum()
        self._kept: np.ndarray | None = None
        self._room = np.zeros(0)

    def __call__(self, block: np.ndarray) -> np.ndarray:
        """Return the output samples that this further block completes, shape (samples, channels)."""
        held = block.shape[0] + (0 if self._kept is None else self._kept.shape[0])
        channels, width = block.shape[1], self.taps.size
        count = max(0, (held - width) // self.factor + 1)
        # Samples together make one product with a matrix that has the taps in each row, moved on by the factor.
        rows, tiles = ROWS, -(-count // ROWS)
        columns = width + (rows - 1) * self.factor
        size = rows * columns, (held + rows * self.factor) * channels, tiles * rows * channels
        if self._room.size < sum(size):
            self._room = np.zeros(sum(size))
        matrix, samples, results = np.split(self._room[: sum(size)], np.cumsum(size)[:2])
        matrix[:], results[:] = self._matrix(rows, channels), 0.0
        samples = samples.reshape(-1, channels)
        new = held - block.shape[0]
        samples[:new], samples[new:held], samples[held:] = self._kept if new else 0.0, block, 0.0
        self._kept = samples[count * self.factor : held].copy()
        if count == 0:
            return np.zeros((0, channels))
        from .product import add_products

        tile = np.arange(tiles)
        program = np.zeros((tiles, 5), dtype=np.int64)
        program[:, 0] = size[0] + tile * rows * self.factor * channels
        program[:, 1], program[:, 3] = columns, rows
        program[:, 2] = size[0] + size[1] + tile * rows * channels
        add_products(self._room, program, 0, tiles, channels)
        return results.reshape(-1, channels)[:count].copy()

    def _matrix(self, rows: int, channels: int) -> np.ndarray:
        matrix = np.zeros((rows, self.taps.size + (rows - 1) * self.factor))
        for row in range(rows):
            matrix[row, row * self.factor : row * self.factor + self.taps.size] = self.taps
        return (matrix.T if channels == 1 else matrix).ravel()
