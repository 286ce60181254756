"""Units: definitions first (exact factors), then spellings, then what must stay unknown."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.datasets.errors import InvalidValueError
from rotorwise.datasets.units import SI_UNIT, parse_sensitivity, parse_unit, require_unit


@pytest.mark.parametrize(
    ("text", "quantity", "to_si"),
    [
        # Standard gravity (CGPM 1901), inch = 25.4 mm exactly (1959), mil = 0.001 in, rpm = 2 pi / 60 rad/s.
        ("g", "acceleration", 9.80665),
        ("mg", "acceleration", 9.80665e-3),
        ("m/s2", "acceleration", 1.0),
        ("mm/s", "velocity", 1e-3),
        ("in/s", "velocity", 0.0254),
        ("mil", "displacement", 25.4e-6),
        ("um", "displacement", 1e-6),
        ("mPa", "sound_pressure", 1e-3),
        ("mV", "voltage", 1e-3),
        ("rpm", "rotational_speed", 2 * math.pi / 60),
        ("deg", "angle", math.pi / 180),
    ],
)
def test_factors_follow_from_the_definitions(text: str, quantity: str, to_si: float) -> None:
    unit = require_unit(text)
    assert unit.quantity == quantity
    assert unit.to_si == pytest.approx(to_si, rel=1e-15)
    assert unit.quantity in SI_UNIT


@pytest.mark.parametrize(
    ("spellings", "unit"),
    [
        (("m/s^2", "[m/s²]", "(m/s**2)", " M/S2 ", "m/sec^2"), "m/s2"),
        (("G", "gn", "g's", "[g]"), "g"),
        (("µm", "μm", "micron", "um"), "um"),
        (("ips", "in/sec", "IN/S"), "in/s"),
        (("mils", "thou"), "mil"),
        (("Volts", "V", "v"), "V"),
        (("r/min", "1/min", "RPM"), "rpm"),
        (("°", "degrees", "[Deg]"), "deg"),
    ],
)
def test_spellings(spellings: tuple[str, ...], unit: str) -> None:
    for text in spellings:
        found = parse_unit(text)
        assert found is not None, text
        assert found.text == unit


def test_case_tells_pascal_from_millipascal_and_nothing_is_guessed() -> None:
    assert require_unit("mPa").to_si == 1e-3
    assert require_unit("Pa").to_si == 1.0
    for text in ("", "()", "EU", "counts", "furlong", "m/s3", "dB", "g/Hz"):
        assert parse_unit(text) is None
    assert parse_unit(None) is None
    with pytest.raises(InvalidValueError, match=r"'EU'.*m/s2"):
        require_unit("EU")


def test_a_sensitivity_divides_out() -> None:
    # 100 mV/g: 1 g gives 0.1 V, so volts per m/s2 is 0.1 / 9.80665.
    assert parse_sensitivity("100 mV/g").volts_per_si == pytest.approx(0.1 / 9.80665)
    # Eddy-current probe, API 670: 200 mV/mil = 7.87 V/mm.
    assert parse_sensitivity("200 mV/mil").volts_per_si == pytest.approx(
        parse_sensitivity("7.874 V/mm").volts_per_si, rel=1e-4
    )
    assert parse_sensitivity("4 mV/(mm/s)").quantity == "velocity"
    assert parse_sensitivity("-100mV/g").volts_per_si < 0


@pytest.mark.parametrize(
    "text",
    ["", "100", "100 mV", "mV/g", "0 mV/g", "100 A/g", "100 mV/EU", "nan mV/g", "1e999 V/g", "1-2 V/g"],
)
def test_sensitivities_that_are_refused(text: str) -> None:
    with pytest.raises(InvalidValueError, match="100 mV/g"):
        parse_sensitivity(text)


@given(st.text(max_size=12))
def test_any_text_is_a_known_unit_or_none(text: str) -> None:
    unit = parse_unit(text)
    assert unit is None or (unit.quantity in SI_UNIT and unit.to_si > 0)


@given(st.text(max_size=12))
def test_any_text_is_a_sensitivity_or_a_clear_error(text: str) -> None:
    try:
        assert math.isfinite(parse_sensitivity(text).volts_per_si)
    except InvalidValueError as error:
        assert "slash" in str(error)  # noqa: PT017
