"""What a measuring chain does to single probes, and hum wherever it lies: named as such, not as the machine's fault."""

import dataclasses

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.words import headline
from rotorwise.simulators import rigid_coupling

from .made_campaigns import recorded

#: The second speed has its third multiple 0.05 Hz from the supply's frequency.
SPEEDS_RPM = (640.0, 1001.0, 1300.0, 1700.0)
COMPETING = frozenset(
    ("unbalance", "coupling_misalignment", "support_anisotropy", "remounted_sensor", "run_out", "mains_hum")
)


def _recorded(seed: int) -> tuple[Recording, ...]:
    real = rigid_coupling.with_parameters(support_2_n_m=1.04 * rigid_coupling.values["support_2_n_m"])
    return recorded(real, SPEEDS_RPM, rate_hz=500.0, duration_s=8.0, seed=seed, settle_s=40.0)


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return Campaign(_recorded(51), _recorded(52))


def _with(campaign: Campaign, change) -> Campaign:
    """The campaign whose recordings have their lateral signals, by the channels' names, changed in place."""
    found = []
    for number, one in enumerate(campaign.recordings):
        signals = one.signals.copy()
        rows = {c.name: signals[i] for i, c in enumerate(one.channels) if c.unit == "m"}
        change(rows, number, np.arange(one.samples) / one.rate_hz)
        found.append(dataclasses.replace(one, signals=signals))
    return dataclasses.replace(campaign, recordings=tuple(found))


@pytest.mark.slow
def test_one_probe_with_another_gain_is_named_and_the_other_left_alone(campaign):
    def louder(rows, number, time_s):
        rows["rotor_2.y"][:] *= 1.25

    found = explain_gap(_with(campaign, louder), rigid_coupling, only=COMPETING)
    assert (found.kind, [(c.effect, c.at) for c in found.causes]) == ("one cause", [("remounted_sensor", "rotor_2.y")])
    gain = found.causes[0].parameters["gain_change"]
    assert gain.low < 0.25 < gain.high < 0.3


@pytest.mark.slow
def test_a_sensor_turned_to_the_other_side_is_named(campaign):
    # The prior's middle is turned from x to y; as many are turned back.
    def turned(rows, number, time_s):
        x, y = rows["rotor_2.x"].copy(), rows["rotor_2.y"].copy()
        rows["rotor_2.x"][:] = 0.95 * (x * np.cos(0.2) - y * np.sin(0.2))
        rows["rotor_2.y"][:] = 0.95 * (y * np.cos(0.2) + x * np.sin(0.2))

    # So many that the sensor's is not followed to the end, unless its first look sees that.
    rivals = COMPETING | {"rotating_coupling_force", "bolt_loss", "rub"}
    found = explain_gap(_with(campaign, turned), rigid_coupling, only=rivals)
    assert (found.kind, [(c.effect, c.at) for c in found.causes]) == ("one cause", [("remounted_sensor", "rotor_2")])
    values = found.causes[0].parameters
    assert values["rotation_rad"].low < -0.2 < values["rotation_rad"].high
    assert values["gain_change"].low < -0.05 < values["gain_change"].high


@pytest.mark.slow
def test_hum_is_named_although_it_meets_an_order_in_one_record(campaign):
    generator = np.random.default_rng(5)
    size = 0.05 * max(np.std(row) for row in campaign.recordings[1].signals[:-1])
    starts = generator.uniform(0, 2 * np.pi, len(SPEEDS_RPM))

    def humming(rows, number, time_s):
        for row in rows.values():
            row += size * np.cos(2 * np.pi * 50.0 * time_s + starts[number])

    found = explain_gap(_with(campaign, humming), rigid_coupling, only=COMPETING)
    assert (found.kind, [c.effect for c in found.causes]) == ("one cause", ["mains_hum"])


def test_run_out_of_any_shape_is_named(campaign):
    heights, places = (6e-6, 2e-6, 4e-6, 1e-6), (0.4, 2.0, -1.0, 0.7)

    def scratched(rows, number, time_s):
        turn = 2 * np.pi * campaign.recordings[number].condition.speed_rpm / 60 * time_s
        for name, behind in (("rotor_1.x", 0.0), ("rotor_1.y", np.pi / 2)):
            for n, (height, place) in enumerate(zip(heights, places, strict=True), start=1):
                rows[name] += height * np.cos(n * (turn - behind + place))

    found = explain_gap(_with(campaign, scratched), rigid_coupling, only=COMPETING)
    assert (found.kind, [(c.effect, c.at) for c in found.causes]) == ("one cause", [("run_out", "rotor_1")])
    for n, height in enumerate(heights, start=1):
        estimate = found.causes[0].parameters[f"harmonic_{n}_m"]
        assert estimate.low < height < estimate.high


def test_a_record_that_does_not_repeat_is_not_called_nothing(campaign):
    generator = np.random.default_rng(3)
    quiet = explain_gap(campaign, rigid_coupling, only=frozenset(("unbalance",)))
    assert quiet.kind == "none"

    def restless(rows, number, time_s):
        for row in rows.values():
            row += (0.3 * row.std() if number == 2 else 0.0) * generator.normal(size=row.size)

    found = explain_gap(_with(campaign, restless), rigid_coupling, only=frozenset(("unbalance",)))
    assert (found.kind, found.causes) == ("unknown", ())
    assert {"rotor_2.x", "rotor_2.y"} <= set(found.flawed)
    assert any("1300 rpm" in said and "does not repeat" in said for said in found.remarks)
    assert "seen in the waveform of rotor_2.x and rotor_2.y" in headline(found)
