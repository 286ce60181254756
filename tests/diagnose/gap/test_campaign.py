"""From files to a campaign: which channel is which probe, which file is healthy, what is refused."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.datasets.metadata import Metadata
from rotorwise.datasets.reading import read
from rotorwise.datasets.recording import Channel, OperatingCondition, Recording
from rotorwise.datasets.simulated import record_machine
from rotorwise.datasets.write import write_recording
from rotorwise.diagnose.gap import fitness
from rotorwise.diagnose.gap.campaign import find_sources, parse_loads, read_campaign
from rotorwise.diagnose.gap.channels import as_probes, match_channels, parse_probes
from rotorwise.diagnose.gap.fitness import UnfitRecordingError, fit
from rotorwise.diagnose.gap.reader_warnings import warnings_told
from rotorwise.diagnose.result import SpeedEstimate
from rotorwise.diagnose.signal.speed import NEAR_HINT
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine

ROTOR, RIG = find_machine("amb_rotor"), find_machine("test_rig")
PROBES, RIG_PROBES = ROTOR.bare_assembly().probes, RIG.bare_assembly().probes
TACHO = Channel("tacho", "tacho")
#: Channels of a measured file, as somebody would describe the probes of the test rig.
MEASURED = (
    Channel("DE H", "acceleration", "housing A", "horizontal"),
    Channel("DE V", "acceleration", "housing A", "vertical"),
    Channel("NDE H", "acceleration", "housing_b", "x"),
    Channel("motor", "rotational_speed"),
    TACHO,
)


TIME = np.arange(4000) / 1000
PULSES = (25 * TIME % 1 < 0.1).astype(float)


def recording(*channels: Channel) -> Recording:
    """Return a record of a shaft at 25 Hz in which every channel is another one."""
    rows = [PULSES if one.quantity == "tacho" else np.cos(2 * np.pi * 25 * TIME + i) for i, one in enumerate(channels)]
    return Recording(np.array(rows), 1000.0, channels, OperatingCondition(1500.0), label="unbalance")


def by_name(one: Recording, *, given: dict[str, str] | None = None, rig: bool = True) -> dict[str, str]:
    found = match_channels(one, RIG_PROBES if rig else PROBES, given=given or {})
    return {one.channels[i].name: name for i, name in found.probes.items()}


# ---- channels ----


def test_names_of_probes_match_themselves() -> None:
    channels = [Channel(probe.name, "displacement") for probe in PROBES]
    assert by_name(recording(*channels, TACHO), rig=False) == {probe.name: probe.name for probe in PROBES}


@given(st.permutations(MEASURED))
def test_place_and_way_match_whatever_the_order(channels: list[Channel]) -> None:
    assert by_name(recording(*channels)) == {"DE H": "housing_a_x", "DE V": "housing_a_y", "NDE H": "housing_b_x"}


def test_way_alone_matches_only_where_nothing_else_could_be_meant() -> None:
    axial, speed = Channel("ax", "acceleration", None, "axial"), Channel("n", "rotational_speed")
    gearbox = find_machine("gearbox").bare_assembly().probes
    only_x = Channel("h", "acceleration", None, "horizontal")
    assert match_channels(recording(only_x), gearbox, given={}).probes == {0: "bearing 1 x"}
    with pytest.raises(InvalidValueError) as problem:
        match_channels(recording(axial, speed), RIG_PROBES, given={})
    said = str(problem.value)
    assert "ax (could be housing_a_axial or housing_b_axial" in said
    assert "--probe CHANNEL=PROBE" in said
    assert all(probe.name in said for probe in RIG_PROBES)


def test_two_channels_never_become_one_probe() -> None:
    twins = [Channel(name, "acceleration", "housing_a", "x") for name in ("first", "second")]
    other = Channel("other", "acceleration", "housing_a", "y")
    found = match_channels(recording(*twins, other), RIG_PROBES, given={})
    assert found.probes == {2: "housing_a_y"}
    assert set(found.left) == {"first", "second"}


def test_what_the_user_says_counts_first() -> None:
    swapped = parse_probes(["DE H=housing_b_x", "3 = housing_a_x"], RIG_PROBES)
    assert by_name(recording(*MEASURED), given=swapped) == {
        "DE H": "housing_b_x",
        "DE V": "housing_a_y",
        "NDE H": "housing_a_x",
    }
    assert parse_probes(["a=b=path_1"], PROBES) == {"a=b": "path_1"}


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (["path_1"], "allowed: CHANNEL=PROBE"),
        (["X=path_9"], "no probe 'path_9'; allowed: path_1, path_2"),
        (["X=path_1", "Y=path_1"], "named twice"),
        (["X=path_1", "X=path_2"], "named twice"),
    ],
)
def test_wrong_probe_texts_are_refused(texts: list[str], words: str) -> None:
    with pytest.raises(InvalidValueError, match=words):
        parse_probes(texts, PROBES)


@pytest.mark.parametrize(
    ("channel", "words"),
    [
        (
            Channel("path_1", "acceleration"),
            "is acceleration; probe path_1 measures displacement.*Nothing is integrated",
        ),
        (Channel("path_1"), "has no known unit.*--unit"),
        (Channel("path_1", "voltage"), "is voltage.*--sensitivity"),
    ],
)
def test_quantities_must_agree(channel: Channel, words: str) -> None:
    with pytest.raises(InvalidValueError, match=words):
        match_channels(recording(channel), PROBES, given={})


def test_a_channel_that_is_not_there_is_named() -> None:
    with pytest.raises(InvalidValueError, match="channel 'Z'; allowed: X, or a number from 1 to 1"):
        match_channels(recording(Channel("X", "displacement")), PROBES, given={"Z": "path_1"})


def test_probes_keep_their_samples_and_the_tacho_stays() -> None:
    one = recording(*MEASURED)
    ready = as_probes(one, match_channels(one, RIG_PROBES, given={}))
    assert [channel.name for channel in ready.channels] == ["housing_a_x", "housing_a_y", "housing_b_x", "tacho"]
    np.testing.assert_array_equal(ready.signals, one.signals[[0, 1, 2, 4]])


# ---- files ----


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign with two recordings, one healthy one, and a file that is none."""
    base = tmp_path_factory.mktemp("campaign")
    (base / "baseline").mkdir()
    for name, speed in (("slow.csv", 1500.0), ("fast.csv", 3000.0), ("baseline/ok.csv", 1600.0)):
        made = record_machine(ROTOR, speed_rpm=speed, duration_s=0.2, rate_hz=1000.0).recording
        write_recording(made, base / name, file_format="csv", notes={}, remarks="", force=True)
    (base / "photo.xyz").write_bytes(b"\x00\x01nothing")
    return base


def test_a_folder_is_a_campaign_with_its_baseline(folder: Path) -> None:
    sources = find_sources([folder])
    assert [one.name for one in sources.recordings] == ["fast.csv", "slow.csv"]
    assert [one.name for one in sources.baseline] == ["ok.csv"]
    taken = read_campaign(sources, ROTOR)
    assert taken.probes == tuple(probe.name for probe in PROBES)
    assert taken.campaign.name == folder.name
    assert [one.label for one in taken.campaign.recordings] == [None, None]
    np.testing.assert_array_equal(taken.campaign.recordings[1].signals, read(folder / "slow.csv").signals)
    assert len(taken.campaign.baseline) == 1
    assert taken.notes == ("photo.xyz: no format that a reader knows; left out.",)


def test_a_named_baseline_replaces_the_sub_folder_and_is_not_explained(folder: Path) -> None:
    sources = find_sources([folder], baseline=[folder / "slow.csv"])
    assert [one.name for one in sources.recordings] == ["fast.csv"]
    assert [one.name for one in sources.baseline] == ["slow.csv"]
    with pytest.raises(InvalidValueError, match="named as healthy ones as well"):
        find_sources([folder / "slow.csv"], baseline=[folder])


def test_a_file_that_cannot_be_read_is_told_and_left_out(folder: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.npz"
    broken.write_bytes(b"PK\x03\x04 cut")
    taken = read_campaign(find_sources([folder / "slow.csv", broken]), ROTOR)
    assert len(taken.campaign.recordings) == 1
    assert len(taken.unreadable) == 1
    assert "broken.npz" in taken.unreadable[0]
    with pytest.raises(UnfitRecordingError, match="No recording can be used"):
        read_campaign(find_sources([broken]), ROTOR)


def test_a_recording_that_is_there_twice_counts_once(folder: Path, tmp_path: Path) -> None:
    twice = tmp_path / "twice"
    shutil.copytree(folder, twice)
    first = sorted(one for one in twice.iterdir() if one.is_file() and one.suffix != ".toml")[0]
    shutil.copy(first, twice / f"zz{first.suffix}")
    shutil.copy(first, twice / "baseline" / f"zz{first.suffix}")
    before, taken = (read_campaign(find_sources([one]), ROTOR) for one in (folder, twice))
    assert len(taken.campaign.recordings) == len(before.campaign.recordings)
    assert len(taken.campaign.baseline) == len(before.campaign.baseline) + 1
    told = [note for note in taken.notes if "the same samples" in note]
    assert ["left out" in note for note in told] == [True, False]
    assert "check which it is" in told[1]


def test_healthy_recordings_that_are_all_copies_are_refused(folder: Path, tmp_path: Path) -> None:
    copies = tmp_path / "copies"
    shutil.copytree(folder, copies)
    shutil.rmtree(copies / "baseline")
    (copies / "baseline").mkdir()
    for one in ("slow.csv", "slow.csv.toml", "fast.csv", "fast.csv.toml"):
        if (copies / one).exists():
            shutil.copy(copies / one, copies / "baseline" / f"h_{one}")
    with pytest.raises(InvalidValueError, match="hold the same samples as others"):
        read_campaign(find_sources([copies]), ROTOR)


def test_what_readers_warn_of_is_told_once_with_the_file() -> None:
    one, two = recording(Channel("A", "acceleration")), recording(Channel("A", "acceleration"))
    of_all, of_one = "The given unit contradicts the file's.", "12 time stamps are missing."
    both = [replace(one, warnings=(of_all, of_one)), replace(two, warnings=(of_all,))]
    assert warnings_told(both) == [of_all, f"recording: {of_one}"]
    many = [replace(one, warnings=tuple(map(str, range(9))))] * 2
    assert warnings_told(many)[:6] == list("012345")
    assert warnings_told(many)[6:] == ["3 more warnings of the readers; analyse tells them."]


def test_a_folder_s_sidecar_holds_for_its_baseline_too(tmp_path: Path) -> None:
    (tmp_path / "baseline").mkdir()
    for name, shift in (("run.csv", 0.0), ("baseline/run.csv", 0.5)):
        turns = 25 * np.arange(PULSES.size) + shift
        rows = [f"{np.sin(turn):.5f},{np.cos(turn):.5f},{p:g}" for turn, p in zip(turns, PULSES, strict=True)]
        (tmp_path / name).write_text("\n".join(["a,b,c", *rows]))
    (tmp_path / "recording.toml").write_text(
        '[recording]\nrate_hz = 1000.0\nunit = "um"\nchannel_names = ["path_1", "path_2", "once"]\ntacho = "once"\n'
    )
    taken = read_campaign(find_sources([tmp_path]), ROTOR)
    assert taken.probes == ("path_1", "path_2")
    first, healthy = taken.campaign.recordings[0], taken.campaign.baseline[0]
    for one in (first, healthy):
        assert np.abs(one.signals[:2]).max() == pytest.approx(1e-6, rel=1e-3)


def test_only_probes_that_all_recordings_have_are_compared(folder: Path, tmp_path: Path) -> None:
    one = read(folder / "slow.csv")
    write_recording(one.select([1, 4]), tmp_path / "part.csv", file_format="csv", notes={}, remarks="", force=True)
    taken = read_campaign(find_sources([folder / "slow.csv", tmp_path / "part.csv"]), ROTOR)
    assert taken.probes == ("path_2",)
    assert [[c.name for c in r.channels] for r in taken.campaign.recordings] == [["path_2", "tacho"]] * 2
    assert "Channel path_1 is not compared: it cannot be used in every recording (1 of 2 recordings)." in taken.notes
    write_recording(one.select([0, 4]), tmp_path / "else.csv", file_format="csv", notes={}, remarks="", force=True)
    with pytest.raises(InvalidValueError, match="no probe in common"):
        read_campaign(find_sources([tmp_path / "part.csv", tmp_path / "else.csv"]), ROTOR)


# ---- whether a recording is fit ----


def fitted(rows: np.ndarray, *channels: Channel, hint_rpm: float | None = None):
    one = Recording(rows, 1000.0, channels, OperatingCondition(hint_rpm))
    return fit(one, match_channels(one, PROBES, given={}))


X, Y = Channel("path_1", "displacement"), Channel("path_2", "displacement")


def test_a_speed_that_nothing_shows_is_not_guessed() -> None:
    """A single tone fits many speeds; a comb of lines near the stated speed, or a tacho, leaves no doubt."""
    tone = np.cos(2 * np.pi * 25 * TIME)
    with pytest.raises(UnfitRecordingError, match=r"--tacho, give the speed"):
        fitted(tone[None], X)
    assert fitted(np.array([tone, PULSES]), X, TACHO)[2] == []
    noise = 0.01 * np.random.default_rng(0).normal(size=TIME.size)
    comb = sum(np.cos(2 * np.pi * 25.3 * k * TIME) / k for k in range(1, 7)) + noise
    assert fitted(comb[None], X, hint_rpm=1500.0)[2] == []


@pytest.mark.parametrize(
    ("rpm", "confidence", "taken"), [(1502, 0.6, 1), (1502, 0.4, 0), (1520, 0.6, 0), (1520, 0.75, 1)]
)
def test_a_doubtful_line_is_taken_where_it_lies_at_the_stated_speed_itself(monkeypatch, rpm, confidence, taken):
    speed = SpeedEstimate(rpm / 60, rpm / 60, rpm / 60, confidence, NEAR_HINT)
    monkeypatch.setattr(fitness, "observe", lambda _: SimpleNamespace(speed=speed))
    if taken:
        assert fitted(np.cos(2 * np.pi * 25 * TIME)[None], X, hint_rpm=1500.0)[2] == []
    else:
        said = rf"near the 1500 rpm that are stated \({rpm:.1f} rpm with {confidence:.0%} confidence\)"
        with pytest.raises(UnfitRecordingError, match=said):
            fitted(np.cos(2 * np.pi * 25 * TIME)[None], X, hint_rpm=1500.0)


def test_dead_channels_are_left_out_and_gaps_filled() -> None:
    wave = np.cos(2 * np.pi * 25 * TIME)
    holed = wave.copy()
    holed[1000] = np.nan
    ready, matched, doubts = fitted(np.array([holed, 0 * wave, PULSES]), X, Y, TACHO)
    assert matched.probes == {0: "path_1"}
    assert "constant signal" in matched.left["path_2"]
    assert ready.signals[0, 1000] == pytest.approx((wave[999] + wave[1001]) / 2)
    assert [("constant" in one, "filled in" in one) for one in doubts] == [(False, True), (True, False)]
    with pytest.raises(UnfitRecordingError, match=r"no usable channel\. path_1: constant signal"):
        fitted(np.array([0 * wave, PULSES]), X, TACHO)


def test_a_run_up_is_told_of() -> None:
    turns = 25 * TIME + 0.5 * 3 * TIME**2
    rows = np.array([np.cos(2 * np.pi * turns), (turns % 1 < 0.1).astype(float)])
    assert any("the speed changes by" in one for one in fitted(rows, X, TACHO)[2])


# ---- loads ----


@pytest.fixture
def rig_file(tmp_path: Path) -> Path:
    channels = tuple(replace(one, direction=None) if one.quantity == "tacho" else one for one in MEASURED)
    one = replace(recording(*channels), condition=OperatingCondition(1500.0))
    write_recording(one, tmp_path / "rig.csv", file_format="csv", notes={}, remarks="", force=True)
    return tmp_path / "rig.csv"


def test_loads_are_in_the_machine_s_unit_and_within_its_bounds(rig_file: Path) -> None:
    def load(*texts: str, **said: object) -> float | None:
        known = Metadata(**said)  # pyright: ignore[reportArgumentType]
        taken = read_campaign(find_sources([rig_file]), RIG, metadata=known, loads=texts)
        return taken.campaign.recordings[0].condition.load

    assert load() is None
    assert load(load=2.0, load_unit="kg") == 2.0
    assert load(load=10.0, load_unit="lb") == pytest.approx(4.5359237)
    assert load("3", load=50.0, load_unit="%") == 3.0
    assert load("3", "rig*=4", "other=5") == 4.0
    with pytest.raises(InvalidValueError, match=r"load 50 %.*in kg. Give it with --load rig.csv=VALUE"):
        load(load=50.0, load_unit="%")
    with pytest.raises(InvalidValueError, match=r"rig.csv: shaft_load_kg = 1000000.0; allowed.*Or give another with"):
        load(load=1e6)
    with pytest.raises(InvalidValueError, match="is not a number"):
        load("much")


def test_a_load_for_a_machine_without_one_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="amb_rotor has no load"):
        parse_loads(["3"], ROTOR)
    with pytest.raises(InvalidValueError, match="PATTERN=VALUE"):
        parse_loads(["=3"], RIG)


def test_an_unknown_load_is_told_of(rig_file: Path) -> None:
    taken = read_campaign(find_sources([rig_file]), RIG, loads=("other*=5",))
    assert "--load other*=5: no recording has such a name." in taken.notes
    assert any(note.startswith("Load not known in 1 of 1 recordings") for note in taken.notes)
    stated = RIG.with_parameters(shaft_load_kg=2.0)
    assert not any("Load not known" in note for note in read_campaign(find_sources([rig_file]), stated).notes)
    said = "Channel motor is not compared: rotational speed, direction not known: say with --probe which probe it is."
    assert said in taken.notes


def test_recordings_that_cannot_be_used_are_told_and_a_baseline_that_is_gone_is_refused(
    folder: Path, tmp_path: Path
) -> None:
    shutil.copytree(folder, tmp_path / "own")
    # Nobody says at which rate it was taken.
    rateless = "\n".join([f"{PROBES[0].name} (m)", *(f"{value:.3f}" for value in np.linspace(0, 1, 200))])
    for kept in (tmp_path / "own").rglob("slow.*"):
        kept.unlink()
    (tmp_path / "own" / "slow.csv").write_text(rateless, encoding="utf-8")
    taken = read_campaign(find_sources([tmp_path / "own"]), ROTOR)
    (told,) = [note for note in taken.notes if note.startswith("1 of 2 recordings cannot be used: slow.csv. ")]
    assert "Give it with --rate HZ" in told
    for kept in (tmp_path / "own" / "baseline").iterdir():
        kept.unlink()
    (tmp_path / "own" / "baseline" / "ok.csv").write_text(rateless, encoding="utf-8")
    with pytest.raises(UnfitRecordingError, match="None of the 1 recordings of the healthy machine"):
        read_campaign(find_sources([tmp_path / "own"]), ROTOR)


def test_a_stated_speed_that_the_vibration_does_not_show_is_told(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).normal(size=4000)
    probe = PROBES[0].name
    path = tmp_path / "run.csv"
    path.write_text("\n".join([f"{probe} (m)", *(f"{1e-6 * value:.6e}" for value in noise)]), encoding="utf-8")
    (tmp_path / "recording.toml").write_text("[recording]\nrate_hz = 1000.0\nspeed_rpm = 1500.0\n", encoding="utf-8")
    with pytest.raises(UnfitRecordingError, match="1500 rpm that are stated"):
        read_campaign(find_sources([path]), ROTOR)
