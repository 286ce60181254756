"""Layouts of text files: one signal, written in many ways, must read as the same signal."""

from __future__ import annotations

import gzip
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.datasets.errors import UnreadableFileError
from rotorwise.datasets.readers import content_blocks, read_content

RATE = 1000.0
N = 300
RNG = np.random.default_rng(7)
X, Y = np.round(RNG.standard_normal((2, N)), 6)
T = np.arange(N) / RATE


def table(columns, separator=",", decimal=".", fmt="{:.6f}", end="\n") -> str:
    rows = (separator.join(fmt.format(value) for value in row) for row in zip(*columns, strict=True))
    return end.join(row.replace(".", decimal) for row in rows) + end


def epoch_ms() -> list[float]:
    return [1_700_000_000_000 + 1000 * t for t in T]


def stamped(fmt: str) -> str:
    start = np.datetime64("2024-03-01T23:59:59.900000", "us")
    out = []
    for t, x, y in zip(T, X, Y, strict=True):
        stamp = str(start + np.timedelta64(round(t * 1e6), "us"))
        out.append(f"{fmt.format(stamp)},{x:.6f},{y:.6f}")
    return "time,ax,ay\n" + "\n".join(out) + "\n"


LAYOUTS = {
    "comma, header, unit": "time,ax,ay\n" + table([T, X, Y]),
    "semicolon, decimal comma": "Time;ax;ay\n" + table([T, X, Y], ";", ","),
    "tab": "t\tax\tay\n" + table([T, X, Y], "\t"),
    "tab, decimal comma": "t\tax\tay\n" + table([T, X, Y], "\t", ","),
    "bar": "t|ax|ay\n" + table([T, X, Y], "|"),
    "blanks": "  " + table([T, X, Y], "   ", end="\n  ").rstrip() + "\n",
    "no header": table([T, X, Y]),
    "no header, time from 17.3": table([T + 17.3, X, Y]),
    "no header, trailing separator": table([T, X, Y], ";", end=";\r\n"),
    "windows line ends": table([T, X, Y], end="\r\n"),
    "old mac line ends": table([T, X, Y], end="\r"),
    "exponents": table([T, X, Y], fmt="{:.8E}"),
    "quoted": '"time","ax","ay"\n' + table([T, X, Y], fmt='"{:.6f}"'),
    "milliseconds in the title": "Time (ms),ax,ay\n" + table([1000 * T, X, Y]),
    "microseconds in brackets": "time [us],ax,ay\n" + table([1e6 * T, X, Y]),
    "row of units": "time;ax;ay\n(s);(g);(g)\n" + table([T, X, Y], ";"),
    "row of units in ms": "time,ax,ay\nms,g,g\n" + table([1000 * T, X, Y]),
    "rate in a comment": "# rate_hz: 1000\nax,ay\n" + table([X, Y]),
    "rate in kHz": "Sampling Frequency;1 kHz\nax;ay\n" + table([X, Y], ";"),
    "rate with equals": "% fs = 1000\n" + table([X, Y]),
    "step": "dt: 0.001\nax,ay\n" + table([X, Y]),
    "savetxt header": "# time ax ay\n" + table([T, X, Y], " "),
    "row number and rate": "# rate_hz: 1000\nindex,ax,ay\n" + table([np.arange(N), X, Y]),
    "row number without header": "# rate_hz: 1000\n" + table([np.arange(N), X, Y], fmt="{:.7g}"),
    "milliseconds since 1970": "timestamp,ax,ay\n" + table([epoch_ms(), X, Y]),
    "dates": stamped("{}"),
    "dates with blank": stamped("{}").replace("T", " "),
    "times of day": stamped("{}").replace("2024-03-01T23:59:59.9", "22:59:59.9").replace("2024-03-02T00", "23"),
    "missing line end": table([T, X, Y]).rstrip(),
    "blank lines": "time,ax,ay\n\n" + table([T, X, Y]).replace("\n", "\n\n"),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_give_the_same_signal(tmp_path: Path, layout: str, encoding: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(LAYOUTS[layout].encode(encoding))
    content = read_content(path)
    np.testing.assert_array_equal(content.signals, [X, Y])
    assert content.rate_hz == pytest.approx(RATE, rel=1e-6)
    assert content.warnings == ()
    if "row of units" in layout:
        assert content.units == ("g", "g")
    if content.channel_names[0].startswith("a"):
        assert content.channel_names == ("ax", "ay")


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_stream_to_the_same_signal(tmp_path: Path, layout: str) -> None:
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(LAYOUTS[layout].encode()))
    parts = list(content_blocks(path, block_samples=70))
    np.testing.assert_array_equal(np.concatenate([part.signals for part in parts], axis=1), [X, Y])
    assert [part.rate_hz for part in parts] == pytest.approx([RATE] * 5, rel=1e-6)
    assert [part.start_sample for part in parts] == [0, 70, 140, 210, 280]


@pytest.mark.parametrize(
    ("titles", "names", "units"),
    [
        ("acc_x (g),ay [m/s^2]", ("acc_x", "ay"), ("g", "m/s^2")),
        ("X:(mm/s),Y:(V)", ("X", "Y"), ("mm/s", "V")),
        ("pump (front),ch 2", ("pump (front)", "ch 2"), (None, None)),
        ("a,a", ("a", "a (2)"), (None, None)),
        ("µ-probe (µm),y (μm)", ("µ-probe", "y"), ("µm", "μm")),
    ],
)
def test_titles_split_into_name_and_unit(tmp_path: Path, titles: str, names: tuple, units: tuple) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"# rate_hz: 1000\n{titles}\n" + table([X, Y]), encoding="utf-8")
    content = read_content(path)
    assert content.channel_names == names
    assert content.units == units


def test_latin1_degree_sign_in_the_preamble(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes("Temperature: 40 °C\nrate_hz: 1000\nax,ay\n".encode("latin-1") + table([X, Y]).encode())
    content = read_content(path)
    assert content.notes["Temperature"] == "40 °C"
    assert content.rate_hz == RATE


def test_decimal_comma_in_a_single_column(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("rate_hz: 1000\n" + table([X / 100], decimal=","))
    np.testing.assert_allclose(read_content(path).signals, [np.round(X / 100, 6)], atol=1e-12)


def test_preamble_gives_speed_label_and_promised_length(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text(
        f"Sample Rate:\t1000\nRPM:\t1480\nLabel:\thealthy\nBlock Size:\t{N + 5}\nY Axis Unit:\t(g)\n" + table([X])
    )
    content = read_content(path)
    assert (content.speed_rpm, content.label, content.units) == (1480.0, "healthy", ("g",))
    assert "promises 305 samples but 300" in content.warnings[0]


def test_phone_with_repeated_stamps_reads_with_a_warning(tmp_path: Path) -> None:
    # Exact: 300 samples over 299 steps of 1/99 s, stamps cut to 20 ms, so that about half repeat.
    stamps = np.floor(np.arange(N) / 99.0 / 0.02) * 0.02
    path = tmp_path / "phone.csv"
    path.write_text("time,ax,ay\n" + table([stamps, X, Y]))
    content = read_content(path)
    assert content.rate_hz == pytest.approx((N - 1) / (stamps[-1] - stamps[0]))
    assert content.rate_hz == pytest.approx(99.0, rel=0.01)
    assert any("repeat the one before" in text for text in content.warnings)


def test_gap_and_jitter_are_told(tmp_path: Path) -> None:
    stamps = T.copy()
    stamps[150:] += 0.05
    path = tmp_path / "gap.csv"
    path.write_text("time,ax\n" + table([stamps, X]))
    assert any("gap" in text.lower() for text in read_content(path).warnings)
    path.write_text("time,ax\n" + table([T + RNG.uniform(0, 3e-4, N), X]))
    assert any("Uneven time steps" in text for text in read_content(path).warnings)


def test_row_number_is_not_time(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time,ax\n" + table([np.arange(N), X]))
    content = read_content(path)
    assert content.rate_hz is None
    assert content.channel_names == ("ax",)
    assert "row number, not time" in content.warnings[0]
    path.write_text(table([np.arange(1, N + 1), X], fmt="{:.7g}"))
    assert read_content(path).rate_hz is None
    assert read_content(path).signals.shape == (1, N)


def test_rate_stated_against_time_column(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("# rate_hz: 500\ntime,ax\n" + table([T, X]))
    content = read_content(path)
    assert content.rate_hz == 500
    assert any("500 Hz" in text and "1000 Hz" in text for text in content.warnings)


def test_missing_cells_stay_missing_and_bad_ones_are_told(tmp_path: Path) -> None:
    lines = table([T, X, Y]).splitlines()
    lines[5] = "0.005000,NaN,1.0"
    lines[6] = "0.006000,,1.0"
    lines[7] = "0.007000,OVERLOAD,1.0"
    path = tmp_path / "a.csv"
    path.write_text("time,ax,ay\n" + "\n".join(lines) + "\n")
    content = read_content(path)
    assert np.flatnonzero(np.isnan(content.signals[0])).tolist() == [5, 6, 7]
    assert not np.isnan(content.signals[1]).any()
    assert content.warnings == ("Column 2: 1 cells are no numbers (first in data row 8); read as missing.",)


def test_incomplete_last_line_is_dropped_with_a_warning(tmp_path: Path) -> None:
    for tail in ("0.3", "0.300000,1.2", "0.300000,1.2,-", "0.300000,1.2,1.5e-"):
        path = tmp_path / "a.csv"
        path.write_text(table([T, X, Y]) + tail)
        content = read_content(path)
        assert content.samples == N
        assert "last line is incomplete" in content.warnings[0]


def test_tables_that_are_no_waveforms_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    for text, word in (
        ("state,rms,peak\n" + "".join(f"healthy,{x},{y}\n" for x, y in zip(X, Y, strict=True)), "words"),
        ("Frequency (Hz),amplitude\n" + table([np.arange(N) * 0.5, np.abs(X)]), "spectrum"),
        ("rpm,amp,phase\n" + table([1000 + 4.2 * np.arange(N), np.abs(X), Y]), "run-up"),
        ("ax,ay\n" + table([X[:40], Y[:40]]), "not a waveform"),
        ("time,flag\n" + "".join(f"{t},ok\n" for t in T), "words"),
    ):
        path.write_text(text)
        with pytest.raises(UnreadableFileError, match=word):
            read_content(path)


def test_first_row_wider_than_the_rest(tmp_path: Path) -> None:
    lines = table([T, X, Y], " ;", end=" \r\n").split("\r\n")
    path = tmp_path / "a.csv"
    path.write_text("\r\n".join([lines[0] + ";0.89;0.91", *lines[1:]]), newline="")
    content = read_content(path)
    np.testing.assert_array_equal(content.signals, [X, Y])
    assert content.notes["extra cells of the first row"] == "0.89 0.91"


def test_40000_rows_of_four_columns_in_well_under_150_ms(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    np.savetxt(
        path,
        np.column_stack([np.arange(40_000) / 20e3, RNG.standard_normal((40_000, 3))]),
        delimiter=";",
        fmt="%.8g",
    )
    best = min(_seconds(path) for _ in range(5))
    assert best < 0.15, f"{best:.3f} s"


def _seconds(path: Path) -> float:
    # Of the processor: others use it as well.
    begin = time.process_time()
    read_content(path)
    return time.process_time() - begin


@given(
    values=st.lists(st.floats(allow_nan=False, allow_infinity=False, width=64), min_size=4, max_size=40),
    separator=st.sampled_from([",", ";", "\t", "|"]),
)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_number_survives_exactly(tmp_path: Path, values: list[float], separator: str) -> None:
    path = tmp_path / "a.csv"
    rows = "".join(f"{value!r}{separator}{-value!r}\n" for value in values)
    path.write_text("# rate_hz: 1000\n" + separator.join(("ax", "ay")) + "\n" + rows)
    np.testing.assert_array_equal(read_content(path).signals, [values, [-value for value in values]])
