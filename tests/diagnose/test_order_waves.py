"""The first orders within a turn, in the report of ``analyse``: what theory says, and where nothing is drawn."""

from __future__ import annotations

import json

import numpy as np
import pytest
from rotorwise.datasets import Metadata
from rotorwise.diagnose import analyse
from rotorwise.diagnose.order_waves import order_waves
from rotorwise.diagnose.report.encode import to_json
from rotorwise.diagnose.report.figures import figures
from rotorwise.diagnose.report.payload import build_payload

from .look_files import RATE, expanded, write_csv

TIME = np.arange(20_000) / RATE
TURN = 2 * np.pi * 25.0 * TIME
NOISE = np.random.default_rng(5).normal(0, 4, TIME.size)


def motion(angle: np.ndarray) -> np.ndarray:
    """Return 1X to 3X in um: flattened on one side."""
    return 40 * np.cos(angle) + 15 * np.cos(2 * angle + 0.6) + 6 * np.cos(3 * angle - 1)


@pytest.fixture
def analysed(tmp_path):
    """Return a function that writes channels and analyses them."""

    def _analysed(columns: dict[str, np.ndarray], **known):
        return analyse(write_csv(tmp_path / "turn.csv", columns), metadata=Metadata(**{"speed_rpm": 1500.0, **known}))

    return _analysed


def test_the_waves_are_those_that_were_put_in(analysed):
    part = analysed({"x (um)": motion(TURN) + NOISE}).pictures.order_part
    assert part.orders == (1.0, 2.0, 3.0)
    assert not part.has_mark
    found = order_waves(part)
    (name, together), *alone = found.waves
    assert name == "1X + 2X + 3X"
    assert found.turns[-1] == pytest.approx(3.0, abs=0.01)
    # The part begins at a whole turn of the speed found, a fraction of a degree a turn off the true one.
    rms = np.sqrt(np.mean((together - 1e-6 * motion(2 * np.pi * found.turns)) ** 2))
    assert rms < 0.03 * together.std()
    for (_, wave), amplitude in zip(alone, (40e-6, 15e-6, 6e-6), strict=True):
        assert np.sqrt(2) * wave.std() == pytest.approx(amplitude, rel=0.05)
    assert np.sum([wave for _, wave in alone], axis=0) == pytest.approx(together)


def test_the_angle_begins_at_the_mark_of_a_tacho(analysed):
    """The speed swings by 2 %, so that the record is resampled; each turn begins where the pulse rises."""
    angle = TURN + 2 * np.pi * 25 * 0.02 * np.sin(2 * np.pi * 0.5 * TIME) / (2 * np.pi * 0.5) + 1.0
    pulse = 5.0 * ((angle / (2 * np.pi)) % 1.0 < 0.05)
    part = analysed({"x (um)": motion(angle) + NOISE, "tacho (V)": pulse}, tacho="tacho").pictures.order_part
    assert part.has_mark
    found = order_waves(part)
    expected = 1e-6 * motion(2 * np.pi * found.turns)
    # An edge lies up to half a sample off: 0.9 degrees at 5 kHz and 25 Hz.
    assert np.corrcoef(found.waves[0][1], expected)[0, 1] > 0.998


def test_the_channel_that_shows_most_orders_is_taken(analysed):
    part = analysed({"dull (um)": 90 * np.cos(TURN) + NOISE, "telling (um)": motion(TURN) + NOISE}).pictures.order_part
    assert part.channel == "telling"


@pytest.mark.parametrize(
    ("signal", "known"),
    [
        (40 * np.cos(TURN), {}),  # a sine is what its line says
        (40 * np.cos(TURN) + 2 * np.cos(2 * TURN), {}),  # nor does a 20th change it visibly
        (0 * TURN, {}),  # no speed
        (np.cos(2 * np.pi * 3.3 * 25 * TIME), {}),  # the speed is no more than stated
        (motion(TURN), {"speed_rpm": 3500.0}),  # and that is wrong
    ],
    ids=["1X alone", "weak 2X", "noise", "a line elsewhere", "wrong speed"],
)
def test_nothing_is_drawn_that_says_nothing(analysed, signal, known):
    found = analysed({"x (um)": signal + 0.1 * NOISE}, **known)
    assert found.pictures.order_part is None
    assert build_payload(found, limit=4000)["turn"] is None
    assert "within a turn" not in figures(build_payload(found, limit=4000), "f0", 3)


def test_the_page_holds_it_closed_in_its_unit(analysed):
    content = build_payload(analysed({"x (um)": motion(TURN) + NOISE}), limit=4000)
    turn = json.loads(to_json(content))["turn"]
    assert (turn["unit"], turn["channel"]) == ("µm", "x")
    assert [one["name"] for one in turn["traces"]] == ["signal", "1X + 2X + 3X", "1X", "2X", "3X"]
    degrees, wave = expanded(turn["traces"][2]["curve"])
    assert degrees[-1] == pytest.approx(1080, abs=3)
    assert wave.max() == pytest.approx(40, rel=0.05)
    assert '<details class="fold"><summary>First orders within a turn' in figures(content, "f0", 3)
