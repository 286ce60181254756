"""Critical speeds of run-ups: modes in closed form, a swept oscillator, and nothing where there is none."""

import numpy as np
import pytest
from rotorwise.diagnose.signal.critical_speed import critical_speeds
from rotorwise.simulators.errors import InvalidValueError
from scipy.integrate import solve_ivp

SPEED = np.linspace(900.0, 3000.0, 60)


def mode(speed_rpm, natural_rpm, ratio):
    return speed_rpm**2 / (natural_rpm**2 - speed_rpm**2 + 2j * ratio * natural_rpm * speed_rpm)


def noise(seed, size):
    return np.random.default_rng(seed).normal(size=(*size, 2)) @ [1, 1j]


def test_one_mode_comes_back_with_run_out_and_modes_above() -> None:
    response = 3e-6 * np.exp(0.7j) * mode(SPEED, 1800.0, 0.03) + 2e-6j + 1e-6 * (SPEED / 3000) ** 2
    (found,) = critical_speeds(SPEED, response[None])
    assert found.speed_rpm == pytest.approx(1800.0, rel=1e-6)
    assert found.damping_ratio == pytest.approx(0.03, rel=1e-5)
    assert found.amplification == pytest.approx(1 / 0.06, rel=1e-5)
    (lagging,) = critical_speeds(SPEED, response.conj()[None])
    assert lagging.speed_rpm == pytest.approx(1800.0, rel=1e-6)


def test_two_modes_of_two_channels() -> None:
    both = np.stack(
        [
            mode(SPEED, 1500.0, 0.03) + 0.3j * mode(SPEED, 1650.0, 0.02),
            0.4 * mode(SPEED, 1500.0, 0.03) - mode(SPEED, 1650.0, 0.02),
        ]
    )
    found = critical_speeds(SPEED, both + 0.1 * noise(0, both.shape))
    assert [one.speed_rpm for one in found] == pytest.approx([1500.0, 1650.0], rel=2e-3)
    assert [one.damping_ratio for one in found] == pytest.approx([0.03, 0.02], rel=0.1)


def test_nine_of_ten_intervals_hold_the_truth() -> None:
    inside = 0
    for seed in range(25):
        response = mode(SPEED, 1800.0, 0.05) + 0.3 * noise(seed, SPEED.shape)
        (found,) = critical_speeds(SPEED, response[None])
        inside += found.low_rpm <= 1800.0 <= found.high_rpm
        inside += found.low_ratio <= 0.05 <= found.high_ratio
    assert 50 * 0.9 - 3 * np.sqrt(50 * 0.09) <= inside


@pytest.mark.parametrize(
    "response",
    [
        (SPEED / 1000) ** 2 + 0.02 * noise(1, SPEED.shape),  # an unbalance far below any mode
        noise(2, SPEED.shape),
        0 * SPEED,
        mode(SPEED, 3200.0, 0.03),  # beyond the range
        mode(SPEED, 800.0, 0.03),
    ],
)
def test_a_run_without_a_resonance_has_none(response) -> None:
    assert critical_speeds(SPEED, response[None]) == ()


def test_too_few_speeds_tell_nothing() -> None:
    few = np.linspace(1700.0, 1900.0, 40)
    assert critical_speeds(few, mode(few, 1800.0, 0.03)[None]) == ()
    assert critical_speeds(SPEED[::6], mode(SPEED[::6], 1800.0, 0.03)[None]) == ()


@pytest.mark.parametrize("ratio", [0.03, 0.1])
@pytest.mark.parametrize("share", [0.1, -0.3, 2.0])
def test_a_sweep_of_an_oscillator_shows_its_frequency(ratio, share) -> None:
    """Integrated in time, up and down, at rates in squares of the decay rate; too fast a run tells nothing."""
    natural = 2 * np.pi * 30
    rate = share * (ratio * natural) ** 2
    begin, end = (0.6 * natural, 1.5 * natural)[:: 1 if share > 0 else -1]
    time = np.linspace(0, (end - begin) / rate, 400)

    def motion(t, y):
        speed, angle = begin + rate * t, begin * t + 0.5 * rate * t**2
        return [y[1], speed**2 * np.exp(1j * angle) - 2 * ratio * natural * y[1] - natural**2 * y[0]]

    run = solve_ivp(motion, (0, time[-1]), [0j, 0j], t_eval=time, rtol=1e-6, atol=1e-8)
    one = run.y[0] * np.exp(-1j * (begin * time + 0.5 * rate * time**2))
    found = critical_speeds((begin + rate * time) * 30 / np.pi, one[None], rate_rpm_s=rate * 30 / np.pi)
    if share > 1:
        assert found == ()
        return
    assert found[0].low_rpm < 1800.0 < found[0].high_rpm
    assert found[0].speed_rpm == pytest.approx(1800.0, rel=0.02)
    assert found[0].damping_ratio == pytest.approx(ratio, rel=0.1)


def test_wrong_input_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="one finite"):
        critical_speeds(SPEED, np.ones((1, 3)))
    with pytest.raises(InvalidValueError, match="one finite"):
        critical_speeds(-SPEED, np.ones((1, SPEED.size)))
