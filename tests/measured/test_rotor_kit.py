"""Bently Nevada RK-4: influence coefficients and the critical speed, as its card has them from the same tables."""

from pathlib import Path

import numpy as np
import pytest
from rotorwise.diagnose.signal.critical_speed import critical_speeds
from rotorwise.diagnose.signal.influence import influence_coefficient

FOLDER = Path(__file__).resolve().parents[3] / "shared/data/09_rk4_rotor_kit"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no measured recordings at {FOLDER}")
#: Of the proximity probes: 7.874 mV/um.
METRES_A_VOLT = 127e-6


def table(name):
    return np.genfromtxt(FOLDER / name, delimiter=",", names=True, dtype=None, encoding="utf-8")


def test_the_critical_speed_of_the_run_up() -> None:
    """Published: first critical speed 1648 rpm; on these points the largest value at 1665 rpm."""
    rows = table("rk4_runup_1x.csv")
    (found,) = critical_speeds(rows["rpm"], (rows["amp_1x_V"] * np.exp(1j * np.radians(rows["phase_1x_deg"])))[None])
    assert found.speed_rpm == pytest.approx(1648.0, rel=0.01)
    assert found.low_rpm < 1665.0
    # The half-power width gives Q = 18.7, the author's own fit 12.4: the shaft is split in x and y.
    assert 12.4 < found.amplification < 30.0


@pytest.mark.parametrize(("speed", "size", "angle_deg"), [("N1", 0.95e-6, -75.0), ("N2", 1.92e-6, -71.0)])
def test_the_influence_of_the_first_disc_on_the_second_plane(speed, size, angle_deg) -> None:
    """Metres per g.mm, linear within 5 %; unbalances of 3 and 6 g.mm are smaller than what varies by itself."""
    rows = table("rk4_1x_vectors.csv")
    rows = rows[(rows["speed_id"] == speed) & ((rows["disk1_unbalance_gmm"] > 6) | (rows["repeat"] == 0))]
    found = influence_coefficient(
        rows["disk1_unbalance_gmm"] * 1e-6, METRES_A_VOLT * (rows["p2x_re_V"] + 1j * rows["p2x_im_V"])
    )
    assert abs(found.coefficient) * 1e-6 == pytest.approx(size, rel=0.05)
    assert np.degrees(np.angle(found.coefficient)) == pytest.approx(angle_deg, abs=3.0)
    assert found.deviation < 0.03 * abs(found.coefficient)
