"""Wavelet denoising: thresholded details, and the low-pass of a four-level approximation."""

from __future__ import annotations

import numpy as np

from ...simulators.errors import InvalidValueError

RULES = ("universal", "sure", "bayes")


def wavelet_denoise(
    signal: np.ndarray,
    *,
    wavelet: str = "db8",
    levels: int | None = None,
    rule: str = "bayes",
    soft: bool = True,
) -> np.ndarray:
    """Return the signal with its wavelet details thresholded.

    Parameters
    ----------
    signal : numpy.ndarray, shape (..., samples)
    wavelet : str
        Any discrete wavelet of PyWavelets.
    levels : int or None
        Depth; None goes as deep as 64 coefficients are left, at most 8: on fewer, the median cannot tell noise from
        signal.
    rule : str
        ``"universal"``: sigma sqrt(2 ln n) (Donoho and Johnstone, Biometrika 81 (1994) 425);
        ``"sure"``: the threshold that minimises Stein's unbiased risk (JASA 90 (1995) 1200), the universal one where
        the level is sparse; ``"bayes"``: sigma^2 / sigma_signal (Chang, Yu and Vetterli, IEEE Trans. Image Process. 9
        (2000) 1532).
    soft : bool
        Shrink (True) or keep-or-kill (False).

    Notes
    -----
    sigma is taken level by level from the median of the details over 0.6745, so that coloured noise is allowed.

    Examples
    --------
    >>> t = np.arange(4096) / 4096
    >>> clean = np.sin(2 * np.pi * 12 * t)
    >>> noisy = clean + np.random.default_rng(0).normal(0, 0.3, t.size)
    >>> bool(np.std(wavelet_denoise(noisy) - clean) < 0.4 * np.std(noisy - clean))
    True
    """
    import pywt

    if rule not in RULES:
        raise InvalidValueError(f"Threshold rule {rule!r}; allowed: {', '.join(RULES)}.")
    array = np.asarray(signal, dtype=float)
    deepest = pywt.dwt_max_level(array.shape[-1], wavelet)
    most = int(np.log2(max(array.shape[-1], 2) / 64))
    depth = max(min(deepest, most, 8), 1) if levels is None else levels
    if not 1 <= depth <= max(deepest, 0):
        raise InvalidValueError(
            f"{depth} wavelet levels on {array.shape[-1]} samples; allowed: 1 to {deepest}. Give a longer record."
        )
    parts = pywt.wavedec(array, wavelet, level=depth, axis=-1)
    shrunk = [parts[0]] + [_shrink(detail, rule, soft) for detail in parts[1:]]
    return pywt.waverec(shrunk, wavelet, axis=-1)[..., : array.shape[-1]]


def _shrink(detail: np.ndarray, rule: str, soft: bool) -> np.ndarray:
    import pywt

    mode = "soft" if soft else "hard"
    rows = []
    for row in detail.reshape(-1, detail.shape[-1]):
        threshold = _threshold(row, rule)
        # Soft thresholding divides by the details: 0/0 where both they and the threshold are 0.
        rows.append(pywt.threshold(row, threshold, mode=mode) if threshold > 0 else row)
    return np.stack(rows).reshape(detail.shape)


def _threshold(row: np.ndarray, rule: str) -> float:
    sigma = float(np.median(np.abs(row)) / 0.6745)
    if sigma == 0.0:
        return 0.0
    universal = sigma * np.sqrt(2 * np.log(row.size))
    if rule == "universal":
        return float(universal)
    if rule == "bayes":
        signal_power = float(np.mean(row**2)) - sigma**2
        return float(sigma**2 / np.sqrt(signal_power)) if signal_power > 0 else float(np.abs(row).max())
    power = np.sort((row / sigma) ** 2)
    count = row.size
    if power.mean() - 1.0 <= np.log2(count) ** 1.5 / np.sqrt(count):
        return float(universal)
    kept = np.arange(count - 1, -1, -1)
    risk = (count - 2 * np.arange(1, count + 1) + np.cumsum(power) + kept * power) / count
    return float(sigma * np.sqrt(power[int(np.argmin(risk))]))


def wavelet_low_pass(signal: np.ndarray, *, levels: int = 4, wavelet: str = "db8") -> np.ndarray:
    """Return the signal rebuilt from the approximation of the last level only.

    Each level drops the upper half of the band: four levels keep 0 to rate/32. This is the noise reduction of the
    bearing-rotor-gear experiment (30 kHz, four layers, low-frequency part of the fourth layer). With db8 a sine is
    kept within 3 % up to half of that edge and rejected below 3 % from 1.5 times it; between, it is partly lost and
    partly mirrored about the edge, so read no lines there.

    Parameters
    ----------
    signal : numpy.ndarray, shape (..., samples)
    levels : int
    wavelet : str
    """
    import pywt

    array = np.asarray(signal, dtype=float)
    deepest = pywt.dwt_max_level(array.shape[-1], wavelet)
    if not 1 <= levels <= deepest:
        raise InvalidValueError(
            f"{levels} wavelet levels on {array.shape[-1]} samples; allowed: 1 to {deepest}. Give a longer record."
        )
    parts = pywt.wavedec(array, wavelet, level=levels, axis=-1)
    kept = [parts[0]] + [np.zeros_like(detail) for detail in parts[1:]]
    return pywt.waverec(kept, wavelet, axis=-1)[..., : array.shape[-1]]
