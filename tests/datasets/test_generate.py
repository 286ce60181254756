"""What a dataset holds: the signals that the simulators give, whoever computes them and beside whom."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from rotorwise.datasets.card import card_text
from rotorwise.datasets.generate import Progress, build, summary_of
from rotorwise.datasets.generate_part import make_part
from rotorwise.datasets.recipe import Recipe
from rotorwise.datasets.recipe_draw import draw_signal, position_of
from rotorwise.datasets.recipe_file import load_recipe, recipe_from_json
from rotorwise.datasets.simulated import record_machine
from rotorwise.datasets.store import Store, open_store
from rotorwise.simulators import amb_rotor, effects
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import machine_from_toml
from rotorwise.simulators.solvers.simulate import simulate_raw

SMALL = Path(__file__).with_name("recipe_small.toml")


def changed(**entries: object) -> Recipe:
    """Return the small recipe with some entries changed."""
    return recipe_from_json(json.dumps({**json.loads(load_recipe(SMALL).source), **entries}, sort_keys=True))


def content(store: Store) -> dict[str, bytes]:
    """Return the bytes of every part."""
    return {path.name: path.read_bytes() for path in sorted((Path(store.folder.name) / "data").iterdir())}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """Return the small dataset, built by this process."""
    return build(SMALL, tmp_path_factory.mktemp("small") / "set", workers=1)


@pytest.fixture(scope="module")
def frame(built: Store) -> pd.DataFrame:
    """Return its table."""
    return pd.read_parquet(Path(built.folder.name) / "data")


def test_every_signal_is_there_once_and_in_order(frame: pd.DataFrame) -> None:
    recipe = load_recipe(SMALL)
    assert frame["signal"].tolist() == list(range(recipe.signals))
    assert frame.groupby("group")["split"].nunique().max() == 1
    assert frame.groupby("split")["group"].nunique().to_dict() == {"test": 3, "train": 3}


def test_a_row_is_what_its_labels_say(frame: pd.DataFrame) -> None:
    row = frame.iloc[37]
    recipe = load_recipe(SMALL)
    drawn = draw_signal(recipe, position_of(recipe, 37))
    machine = machine_from_toml(row["machine_toml"])
    assert machine == drawn.machine
    # Computed anew from the labels alone, with nothing beside it.
    record = record_machine(
        machine,
        speed_rpm=row["speed_rpm"],
        duration_s=row["samples"] / row["rate_hz"],
        rate_hz=row["rate_hz"],
        chain=drawn.chain,
        seed=int(row["seed"]),
        probes=["path_1", "path_2"],
    )
    for channel, signal in zip(record.recording.channels, record.recording.signals, strict=True):
        assert np.array_equal(row[f"signal.{channel.name}"], signal.astype(np.float32))
    assert row["label"] == record.recording.label
    assert row["chain"] == repr(drawn.chain)
    assert row["effect.coupling_misalignment.offset_m"] == row["severity.misalignment_offset_m"] == 4e-5
    assert row["machine.coupling_stiffness_n_m"] == machine.values["coupling_stiffness_n_m"]


def test_the_strength_of_a_fault_is_in_the_signal(frame: pd.DataFrame) -> None:
    """The rotor is linear: what misalignment adds to the motion is in proportion to its offset."""
    machine, speed = machine_from_toml(frame.iloc[0]["machine_toml"]), float(frame.iloc[0]["speed_rpm"])
    phase = float(frame.iloc[2]["effect.coupling_misalignment.offset_phase_rad"])
    added = []
    runs = [
        machine.with_effects(effects.CouplingMisalignment(offset_m=o, angle_rad=0.0, offset_phase_rad=phase))
        for o in (0.0, 1e-5, 4e-5)
    ]
    signals = [r.signals for r in simulate_raw([(m, speed) for m in runs], duration_s=0.2, rate_hz=1000)]
    added = [np.std(one - signals[0]) for one in signals[1:]]
    assert added[1] == pytest.approx(4 * added[0], rel=1e-6)
    # And the dataset's healthy row is the first of these within its noise of at most 1e-7 m/sqrt(Hz).
    healthy = frame.iloc[0]["signal.path_1"] - signals[0][0]
    assert np.std(healthy) < 1.2e-7 * np.sqrt(500)


def test_noise_has_the_density_of_its_label(frame: pd.DataFrame) -> None:
    recipe = load_recipe(SMALL)
    for number in (0, 11, 20):
        row = frame.iloc[number]
        drawn = draw_signal(recipe, position_of(recipe, number))
        still = simulate_raw([(drawn.machine, drawn.speed_rpm)], duration_s=0.2, rate_hz=1000)[0].signals[0]
        density = row["chain.noise.m"]
        assert density == drawn.chain.noise["m"]
        # 200 samples: the deviation is known within 5 %; four times that.
        assert np.std(row["signal.path_1"] - still) == pytest.approx(density * np.sqrt(500), rel=0.2)


def test_the_content_does_not_depend_on_who_computes_it(built: Store, tmp_path: Path) -> None:
    others = build(SMALL, tmp_path / "set", workers=2)
    assert content(others) == content(built)
    assert summary_of(others) == summary_of(built)


def test_the_content_does_not_depend_on_what_is_beside_it(frame: pd.DataFrame, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each signal alone, by a part of its own, is the same signal."""
    from rotorwise.datasets import recipe_parts

    monkeypatch.setattr(recipe_parts, "MOST_RUNS", 1)
    recipe = load_recipe(SMALL)
    assert recipe_parts.Parts(recipe).count == recipe.signals
    for number in (0, 3, 58):
        table = pq.read_table(pa_file(make_part(recipe.source, number).content)).to_pandas()
        row, own = frame.iloc[number], table.iloc[0]
        assert row["signal"] == own["signal"]
        assert all(np.array_equal(row[f"signal.{n}"], own[f"signal.{n}"]) for n in ("path_1", "path_2", "tacho"))


def pa_file(raw: bytes) -> object:
    import pyarrow as pa

    return pa.BufferReader(raw)


def test_records_of_one_run_follow_each_other(tmp_path: Path) -> None:
    machine = json.loads(load_recipe(SMALL).source)["machine"][0]
    exact = {"pulses_per_revolution": 1}
    build(changed(draws=2, machine=[{**machine, "records": 3}], chain=exact), tmp_path / "three", workers=1)
    build(changed(draws=2, machine=[machine], chain=exact, duration_s=0.6), tmp_path / "long", workers=1)
    three, long = (pd.read_parquet(tmp_path / name / "data") for name in ("three", "long"))
    assert len(three) == 3 * len(long)
    assert three["record"].tolist() == [0, 1, 2] * len(long)
    for channel in ("signal.path_1", "signal.tacho"):
        joined = np.concatenate(three[channel].tolist())
        assert np.array_equal(joined, np.concatenate(long[channel].tolist()))
    assert (
        three["severity.misalignment_offset_m"].tolist()
        == np.repeat(long["severity.misalignment_offset_m"], 3).tolist()
    )


def test_records_carry_what_a_sensor_effect_needs_beyond_their_end(tmp_path: Path) -> None:
    """A clock that runs fast sees more than its record; a filter that leaks needs a higher rate."""
    machine = json.loads(load_recipe(SMALL).source)["machine"][0]
    machine["case"] = [
        {"name": "clock", "effect": [{"effect": "clock_error", "rate_error_ppm": 500.0}]},
        {"name": "aliasing", "effect": [{"effect": "aliasing", "leak": 0.5}]},
    ]
    store = build(changed(draws=2, machine=[{**machine, "records": 2}], severity={}), tmp_path / "set", workers=1)
    found = summary_of(store)
    assert (found["rows"], found["refused"]) == (2 * 2 * 2 * 2, [])
    rows = pd.read_parquet(tmp_path / "set" / "data")
    assert {len(signal) for signal in rows["signal.path_1"]} == {200}


def test_a_stiff_contact_beside_it_does_not_change_a_run() -> None:
    """A contact shortens the step; it must not be that of the neighbours."""
    soft, stiff = (
        amb_rotor.with_effects(effects.Rub(stiffness_n_m=k, clearance_m=3e-5, interference_m=0.0)) for k in (1e5, 1e8)
    )
    alone = simulate_raw([(soft, 1500.0)], duration_s=0.1, rate_hz=1000, settle_s=0.2)[0]
    beside, other = simulate_raw([(soft, 1500.0), (stiff, 1500.0)], duration_s=0.1, rate_hz=1000, settle_s=0.2)
    assert other.step_s < alone.step_s
    assert beside.step_s == alone.step_s
    assert np.array_equal(beside.signals, alone.signals)


def test_a_limit_is_a_beginning_and_is_gone_on_with(built: Store, tmp_path: Path) -> None:
    first = build(SMALL, tmp_path / "set", workers=1, limit=13)
    found = summary_of(first)
    assert (found["signals"], found["signals_wanted"], found["rows"]) == (13, 60, 13)
    rows = pd.read_parquet(tmp_path / "set" / "data")["signal"].tolist()
    assert rows == list(range(13))
    seen: list[Progress] = []
    whole = build(SMALL, tmp_path / "set", workers=1, tell=seen.append)
    # The part that was cut short is made again.
    assert seen[0] == Progress(10, 60, 0, 10)
    assert seen[-1] == Progress(60, 60, 0, 10)
    assert content(whole) == content(built)
    # A lower limit later takes nothing away.
    assert content(build(SMALL, tmp_path / "set", workers=1, limit=1)) == content(built)


def test_unstable_and_impossible_draws_are_refused_with_their_reason(tmp_path: Path) -> None:
    """Without its derivative gain the rotor is unstable: refused, while its neighbours stay what they are."""
    source = json.loads(load_recipe(SMALL).source)
    machine = source["machine"][0]
    machine["case"] = [
        {"name": "healthy"},
        {"name": "no damping", "parameters": {"derivative": 0.0}},
        {
            "name": "stiff contact",
            "effect": [{"effect": "rub", "stiffness_n_m": 1e8, "clearance_m": 2e-5, "interference_m": 1e-4}],
        },
    ]
    recipe = changed(draws=2, machine=[machine], severity={})
    found = summary_of(build(recipe, tmp_path / "set", workers=1))
    bad = {one["signal"]: one for one in found["refused"]}
    assert found["signals"] == found["signals_wanted"] == 12
    assert found["rows"] + len(bad) == 12
    assert {2, 3, 8, 9} <= set(bad)
    assert bad[2]["case"] == "no damping"
    assert bad[2]["group"] == "amb_rotor-0"
    assert "unstable" in bad[2]["reason"] or "grew" in bad[2]["reason"]
    alone = build(
        changed(draws=2, machine=[{**machine, "case": machine["case"][:1]}], severity={}), tmp_path / "b", workers=1
    )
    good, healthy = (pd.read_parquet(path / "data") for path in (tmp_path / "set", Path(alone.folder.name)))
    good = good[good["case"] == "healthy"]
    # Other numbers, so other noise; the motion under it is the same to the noise.
    for mine, theirs in zip(good["signal.tacho"], healthy["signal.tacho"], strict=True):
        assert np.array_equal(mine, theirs)
    card = (tmp_path / "set" / "card.md").read_text(encoding="utf-8")
    assert f"{len(bad)} refused" in card
    assert bad[2]["reason"][:40] in card


def test_a_chain_that_gives_no_numbers_is_a_refused_draw(tmp_path: Path) -> None:
    # So small that the filter divides by nothing.
    store = build(changed(chain={"pole_hz": 1e-320}), tmp_path / "set", workers=1, limit=10)
    found = summary_of(store)
    assert (found["rows"], len(found["refused"])) == (0, 10)
    assert "makes no finite signal" in found["refused"][0]["reason"]


def test_a_part_of_nothing_but_refused_draws_is_a_part(tmp_path: Path) -> None:
    machine = json.loads(load_recipe(SMALL).source)["machine"][0]
    machine["case"] = [{"name": "no damping", "parameters": {"derivative": 0.0}}]
    recipe = changed(draws=2, machine=[machine], severity={})
    store = build(recipe, tmp_path / "set", workers=1)
    assert summary_of(store)["rows"] == 0
    assert len(pd.read_parquet(tmp_path / "set" / "data")) == 0
    seen: list[Progress] = []
    build(recipe, tmp_path / "set", workers=1, tell=seen.append)
    assert len(seen) == 1


def test_batches_stream_the_rows(built: Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from rotorwise.datasets import generate_table

    monkeypatch.setattr(generate_table, "ROW_GROUP_BYTES", 3 * 3 * 200 * 4)
    store = build(SMALL, tmp_path / "set", workers=1, limit=10)
    sizes = [batch.num_rows for batch in open_store(store.folder.name).batches(["signal"])]
    assert sizes == [3, 3, 3, 1]
    assert [n for b in built.batches(["signal"]) for n in b.column(0).to_pylist()] == list(range(60))


def test_polars_and_duckdb_read_it_without_us(built: Store, frame: pd.DataFrame) -> None:
    duckdb = pytest.importorskip("duckdb", reason="needs duckdb (pip install duckdb)")
    polars = pytest.importorskip("polars", reason="needs polars (pip install polars)")
    files = f"{built.folder.name}/data/*.parquet"
    mine = polars.scan_parquet(files).filter(polars.col("split") == "train").sort("signal").collect()
    wanted = frame[frame["split"] == "train"]
    assert mine["signal"].to_list() == wanted["signal"].tolist()
    for own, other in zip(mine["signal.path_1"], wanted["signal.path_1"], strict=True):
        assert np.array_equal(own.to_numpy(), other)
    query = f"""select "case", count(*), sum(list_sum("signal.path_2")), max("severity.misalignment_offset_m")
                from '{files}' group by all order by 1"""
    for case, count, total, worst in duckdb.sql(query).fetchall():
        own = frame[frame["case"] == case]
        assert count == len(own)
        assert total == pytest.approx(sum(float(np.sum(s, dtype=float)) for s in own["signal.path_2"]), rel=1e-5)
        assert worst == own["severity.misalignment_offset_m"].max()


def test_the_file_says_units_and_origin_by_itself(built: Store) -> None:
    schema = pq.read_schema(Path(built.folder.name) / "data" / "part-000000.parquet")
    said = schema.field("signal.path_1").metadata
    assert (said[b"unit"], said[b"quantity"]) == (b"m", b"displacement")
    assert schema.field("effect.coupling_misalignment.offset_m").metadata[b"unit"] == b"m"
    facts = json.loads(schema.metadata[b"rotorwise"])
    assert facts["fingerprint"] == load_recipe(SMALL).fingerprint
    assert facts["versions"]["numpy"] == np.__version__


def test_the_card_says_what_is_in_it(built: Store, frame: pd.DataFrame) -> None:
    text = (Path(built.folder.name) / "card.md").read_text(encoding="utf-8")
    assert text == card_text(load_recipe(SMALL), summary_of(built))
    assert "60 signals, 0 refused; complete. Seed 7" in text
    assert "| amb_rotor | parallel misalignment | train | 24 |" in text
    assert "| effect.coupling_misalignment.offset_m | 1e-05, 4e-05 |" in text
    assert "- For tests only." in text
    listed = [line.split("|")[1].strip() for line in text.splitlines() if line.startswith("| ")]
    assert set(frame.columns) <= set(listed)


@pytest.mark.parametrize("options", [{"workers": 0}, {"limit": 0}])
def test_options_that_make_no_sense_are_refused(options: dict[str, int], tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match="= 0; allowed: 1 or more"):
        build(SMALL, tmp_path / "set", **options)
    assert not (tmp_path / "set").exists()
