"""Which causes compete, at which parts, with which unknowns."""

import pytest
from rotorwise.diagnose.gap.hypotheses import candidates
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.machine import find_machine

ROTOR = find_machine("amb_rotor")
PLACES = dict.fromkeys(probe.location for probe in ROTOR.bare_assembly().probes if probe.direction in ("x", "y"))


def competing(name: str, **how):
    others = frozenset(effect_catalogue()) - {name}
    return candidates(ROTOR, without=others, **how)


@pytest.mark.parametrize(
    ("name", "for_all", "for_one"),
    [("mains_hum", True, True), ("remounted_sensor", False, True), ("run_out", False, False)],
)
def test_a_flaw_of_the_measuring_chain_is_tried_where_it_can_sit(name, for_all, for_one):
    parts = {one.effect.at for one in competing(name)}
    probes = {probe.name for probe in ROTOR.bare_assembly().probes if probe.location in PLACES}
    assert parts >= set(PLACES)
    assert ("" in parts) == for_all
    assert (probes <= parts) == for_one


def test_one_probe_at_a_place_is_that_place():
    (probe,) = [probe.name for probe in ROTOR.bare_assembly().probes][:1]
    parts = {one.effect.at for one in competing("mains_hum", probes=[probe])}
    assert len(parts) == 1


def test_a_harmonic_that_is_absent_has_no_angle():
    place = next(iter(PLACES))
    unknowns = [[c.parameter.name for c in one.coordinates] for one in competing("run_out") if one.effect.at == place]
    single = [[f"harmonic_{n}_m", f"angle_{n}_rad"] for n in range(1, 13)]
    assert sorted(unknowns, key=len)[:12] == single
    assert len(max(unknowns, key=len)) == 24


def test_harmonics_of_lines_that_are_not_compared_are_left_out():
    higher = {f"harmonic_{n}_m" for n in range(7, 13)}
    found = competing("run_out", reach=lambda one: float(not higher & {c.parameter.name for c in one.coordinates}))
    whole = max(found, key=lambda one: len(one.coordinates))
    assert len(whole.strengths) == 6
    assert len(whole.coordinates) == 12
    assert not any(whole.effect.values()[name] for name in higher)


def test_forces_add_up_and_those_that_move_nothing_are_left_out():
    # One moves the lines a thousand times less than another and may still be all that acts. Axial ones do nothing.
    def reach(one):
        names = {c.parameter.name for c in one.coordinates}
        return 1e-3 if "forward_3_n" in names else float(not any("axial" in name for name in names))

    found = competing("misalignment_forces", reach=reach)
    assert not any("axial" in c.parameter.name for one in found for c in one.coordinates)
    whole, *single = sorted(found, key=lambda one: -len(one.coordinates))
    assert len(whole.strengths) == 17
    # What acts once a revolution comes with others only: alone it would be another effect.
    names = {one.coordinates[0].parameter.name for one in single}
    assert "forward_3_n" in names
    assert len(names) == len(single) == 13
    assert not any("_1_" in name for name in names)


def test_strengths_that_show_together_only_compete_together():
    def reach(one):
        return float(len(one.strengths) > 1)

    gearbox, others = find_machine("gearbox"), frozenset(effect_catalogue()) - {"housing_resonance"}
    found = candidates(gearbox, without=others, reach=reach)
    assert {one.strength_names for one in found} == {frozenset({"mass_kg", "participation"})}
    assert not candidates(gearbox, without=others, reach=lambda one: 0.0)
