"""Compiled parts of the speed track. Kept apart because importing numba takes half a second."""

from __future__ import annotations

import numpy as np

from ...simulators.compiled_code import njit


@njit(cache=True, error_model="numpy")
def best_path(scores: np.ndarray, price: np.ndarray, path: np.ndarray) -> None:
    """Fill ``path`` with the columns of the dearest way through a table, a row a step (Viterbi).

    Parameters
    ----------
    scores : float64, shape (steps, columns)
    price : float64, shape (2 reach + 1,)
        What a move by -reach to reach columns costs.
    path : int64, shape (steps,)
    """
    steps, columns = scores.shape
    reach = price.size // 2
    origin = np.zeros((steps, columns), dtype=np.int64)
    best = scores[0].copy()
    following = np.empty(columns)
    for step in range(1, steps):
        for column in range(columns):
            top, at = -1e300, column
            for other in range(max(column - reach, 0), min(column + reach, columns - 1) + 1):
                value = best[other] - price[other - column + reach]
                if value > top:
                    top, at = value, other
            following[column] = top + scores[step, column]
            origin[step, column] = at
        best[:] = following
    path[steps - 1] = np.argmax(best)
    for step in range(steps - 1, 0, -1):
        path[step - 1] = origin[step, path[step]]


@njit(cache=True, error_model="numpy")
def path_chances(scores: np.ndarray, weight: np.ndarray, chances: np.ndarray) -> None:
    """Fill ``chances`` with the posterior of every column at every step (forward and backward sums).

    Parameters
    ----------
    scores, chances : float64, shape (steps, columns)
        Logarithms of likelihoods; probabilities, each row sums to 1.
    weight : float64, shape (2 reach + 1,)
        Chance of a move by -reach to reach columns, symmetric.
    """
    steps, columns = scores.shape
    row, spread = np.full(columns, 1.0 / columns), np.full(columns, 1.0 / columns)
    for step in range(steps):
        if step:
            _spread(row, weight, spread)
        chances[step] = spread
        row[:] = spread * np.exp(scores[step] - scores[step].max())
        row /= row.sum()
    row[:] = 1.0 / columns
    for step in range(steps - 1, -1, -1):
        if step < steps - 1:
            _spread(row, weight, spread)
        else:
            spread[:] = 1.0 / columns
        likelihood = np.exp(scores[step] - scores[step].max())
        chances[step] *= spread * likelihood
        chances[step] /= chances[step].sum()
        row[:] = spread * likelihood
        row /= row.sum()


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _spread(row: np.ndarray, weight: np.ndarray, result: np.ndarray) -> None:
    reach = weight.size // 2
    for column in range(row.size):
        total = 1e-300
        for other in range(max(column - reach, 0), min(column + reach, row.size - 1) + 1):
            total += weight[other - column + reach] * row[other]
        result[column] = total


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})
def demodulate(signals: np.ndarray, phase_turns: np.ndarray, block: int, result: np.ndarray) -> None:
    """Fill ``result`` with sums over blocks of samples of signal times exp(-2 pi i h angle), h = 1, 2, ...

    Parameters
    ----------
    signals : float64, shape (channels, samples)
    phase_turns : float64, shape (samples,)
    block : int
    result : complex128, shape (channels, blocks, harmonics)
    """
    channels, blocks, harmonics = result.shape
    powers = np.empty((harmonics, 2))
    for number in range(blocks):
        result[:, number] = 0.0
        for sample in range(number * block, (number + 1) * block):
            angle = -2 * np.pi * (phase_turns[sample] - np.floor(phase_turns[sample]))
            real, imaginary = np.cos(angle), np.sin(angle)
            a, b = real, imaginary
            for harmonic in range(harmonics):
                powers[harmonic, 0], powers[harmonic, 1] = a, b
                a, b = a * real - b * imaginary, a * imaginary + b * real
            for channel in range(channels):
                value = signals[channel, sample]
                for harmonic in range(harmonics):
                    result[channel, number, harmonic] += complex(
                        value * powers[harmonic, 0], value * powers[harmonic, 1]
                    )
