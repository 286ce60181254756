"""Recipes as TOML files: the shipped ones, the user's, and what may stand in one (see `datasets/README.md`)."""

from __future__ import annotations

import difflib
import functools
import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..simulators.effect import effect_catalogue, make_effect
from ..simulators.machine import Machine, find_machine, machine_from_toml
from ..simulators.parameter import Parameter
from .errors import InvalidValueError, RotorwiseError
from .recipe import Case, EffectRecipe, MachineRecipe, Recipe
from .recipe_chain import check_tacho, check_units, parse_chain
from .recipe_values import Choice, parse_choice
from .simulated import MOST_SAMPLES

FORMAT = 1
_TOP = ("name", "meaning", "seed", "draws", "splits", "chain", "severity", "machine", "limits", "rate_hz", "duration_s")
_MACHINE = ("machine", "machine_text", "name", "preset", "probes", "rate_hz", "duration_s", "records", "speed_rpm",
            "load", "priors", "parameters", "case")  # fmt: skip
_CASE = ("name", "instances", "parameters", "effect")
#: More signals than this are a mistake.
MOST_SIGNALS = 10**9


def shipped_recipes() -> tuple[str, ...]:
    """Return the names of the recipes that come with rotorwise."""
    found = files(f"{__package__}.recipes").iterdir()
    return tuple(sorted(file.name.removesuffix(".toml") for file in found if file.name.endswith(".toml")))


def load_recipe(name: str | Path) -> Recipe:
    """Return a shipped recipe by name, or the one of a TOML file.

    Raises
    ------
    InvalidValueError
        When there is none, or something in it is not allowed.
    """
    text = str(name)
    if not text.casefold().endswith(".toml"):
        if text not in shipped_recipes():
            near = difflib.get_close_matches(text, shipped_recipes(), n=1)
            advice = f"Did you mean {near[0]}?" if near else "Name one of them, or a file that ends in .toml."
            raise InvalidValueError(f"Recipe {text!r} is unknown; allowed: {', '.join(shipped_recipes())}. {advice}")
        return _loaded(files(f"{__package__}.recipes").joinpath(f"{text}.toml").read_bytes(), text, Path())
    try:
        return _loaded(Path(name).read_bytes(), text, Path(name).parent)
    except OSError as problem:
        raise InvalidValueError(
            f"Recipe {text} cannot be read: {problem.strerror or problem}. Check the path."
        ) from None


def _loaded(content: bytes, name: str, folder: Path) -> Recipe:
    where = f"Recipe {name}"
    try:
        # Some editors put a mark of the byte order first.
        given = tomllib.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as problem:
        raise InvalidValueError(f"{where} is not valid TOML: {problem}. Correct it at that place.") from None
    if given.pop("format", None) != FORMAT:
        raise InvalidValueError(f"{where}: allowed: format = {FORMAT}. Write it at its top.")
    for entry in _tables(where, given, "machine"):
        machine = _text(where, entry, "machine")
        if machine.casefold().endswith(".toml"):
            # The file's text becomes a part of the recipe: other computers and later builds need no file.
            entry["machine_text"] = machine_from_toml(folder / machine).to_toml()
    given.setdefault("name", Path(name).stem)
    try:
        return recipe_from_json(json.dumps(given, sort_keys=True, default=functools.partial(_refuse, where)), where)
    except RecursionError:
        raise InvalidValueError(
            f"{where} has tables within tables without end; allowed: those of the manual."
        ) from None


def _refuse(where: str, value: object) -> None:
    raise InvalidValueError(f"{where}: {value} is a date or a time; allowed: numbers, texts in quotes. Correct it.")


@functools.lru_cache(maxsize=8)
def recipe_from_json(source: str, where: str = "Recipe") -> Recipe:
    """Return the recipe of `Recipe.source`."""
    given = json.loads(source)
    _check_keys(where, given, _TOP)
    machines = tuple(_machine(where, entry, given) for entry in _tables(where, given, "machine"))
    recipe = Recipe(
        name=_text(where, given, "name"),
        meaning=_text(where, given, "meaning", ""),
        seed=_whole(where, given, "seed", lowest=0),
        draws=_whole(where, given, "draws", lowest=1),
        splits=_splits(where, given.get("splits", {"train": 1.0})),
        chain=parse_chain(f"{where}, chain", given.get("chain", {})),
        severity=_severity(where, given.get("severity", {})),
        machines=machines,
        limits=_texts(where, given, "limits"),
        source=source,
    )
    _check_whole(where, recipe)
    return recipe


def _machine(where: str, entry: dict[str, Any], top: dict[str, Any]) -> MachineRecipe:
    kind = _text(where, entry, "machine")
    name = _text(where, entry, "name", Path(kind).stem)
    where = f"{where}, machine {name}"
    _check_keys(where, entry, _MACHINE)
    try:
        machine = machine_from_toml(entry["machine_text"]) if "machine_text" in entry else find_machine(kind)
        machine = machine.preset(_text(where, entry, "preset")) if "preset" in entry else machine
    except RotorwiseError as problem:
        raise InvalidValueError(f"{where}: {problem}") from None
    declared = {one.name: one for one in machine.definition.parameters}
    load_name = machine.definition.load_parameter
    if "load" in entry and not load_name:
        raise InvalidValueError(f"{where}: load = {entry['load']!r}; {machine.name} has none. Leave it out.")
    parameters = _choices(where, entry, declared, cells=False)
    cases = tuple(_case(where, one, declared) for one in _tables(where, entry, "case"))
    for one in {load_name} & ({*parameters} | {p for case in cases for p in case.parameters}):
        raise InvalidValueError(f"{where}: {one} is the machine's load. Write it as load = ...")
    if "speed_rpm" not in entry:
        raise InvalidValueError(f"{where} has no speed_rpm; there is no default. Give it.")
    return MachineRecipe(
        name=name,
        machine=machine,
        probes=_texts(where, entry, "probes"),
        rate_hz=_positive(where, {**top, **entry}, "rate_hz"),
        duration_s=_positive(where, {**top, **entry}, "duration_s"),
        speed_rpm=parse_choice(f"{where}, speed_rpm", entry["speed_rpm"], _SPEED),
        load=parse_choice(f"{where}, load", entry["load"], declared[load_name]) if "load" in entry else None,
        parameters=parameters,
        cases=cases,
        records=_whole(where, entry, "records", lowest=1, default=1),
    )


_SPEED = Parameter("speed_rpm", "rpm", 1000.0, (1e-3, 1e6), "of the reference shaft", "recipe")


def _case(where: str, entry: dict[str, Any], declared: Mapping[str, Parameter]) -> Case:
    name = _text(where, entry, "name")
    where = f"{where}, case {name}"
    _check_keys(where, entry, _CASE)
    effects = tuple(_effect(where, one) for one in _tables(where, entry, "effect", needed=False))
    columns = [effect.column for effect in effects]
    for column in columns:
        if columns.count(column) > 1:
            raise InvalidValueError(f"{where} has {column} twice; allowed: once at each place. Say where: at = ...")
    parameters = _choices(where, {"parameters": entry.get("parameters", {})}, declared)
    return Case(name, effects, parameters, _whole(where, entry, "instances", lowest=1, default=1))


def _effect(where: str, entry: dict[str, Any]) -> EffectRecipe:
    name, at = _text(where, entry, "effect"), _text(where, entry, "at", "")
    known = effect_catalogue()
    if name not in known:
        raise InvalidValueError(f"{where}: effect {name!r} is unknown; allowed: {', '.join(sorted(known))}.")
    declared = {one.name: one for one in known[name].parameters()}
    said = {key: value for key, value in entry.items() if key not in ("effect", "at", "priors")}
    return EffectRecipe(
        name, at, _choices(f"{where}, {name}", {"parameters": said, "priors": entry.get("priors", False)}, declared)
    )


def _choices(
    where: str, entry: Mapping[str, Any], declared: Mapping[str, Parameter], *, cells: bool = True
) -> dict[str, Choice]:
    """Return what is said of parameters; with ``priors = true`` the others follow their priors, if they have one."""
    said, priors = entry.get("parameters", {}), entry.get("priors", False)
    if not isinstance(said, dict) or not isinstance(priors, bool):
        raise InvalidValueError(f"{where}: allowed: a table parameters, priors = true or false. Correct it.")
    for name in said:
        if name not in declared:
            raise InvalidValueError(f"{where} has no parameter {name!r}; allowed: {', '.join(declared)}.")
    given = {name: "prior" for name, one in declared.items() if priors and one.prior is not None}
    return {
        name: parse_choice(f"{where}, {name}", value, declared[name], cells=cells)
        for name, value in {**given, **said}.items()
    }


def _splits(where: str, given: object) -> dict[str, float]:
    if (
        not isinstance(given, dict)
        or not given
        or not all(
            isinstance(one, int | float) and not isinstance(one, bool) and 0 < one <= 1 for one in given.values()
        )
        or not all(map(_is_readable, given))
    ):
        raise InvalidValueError(f"{where}: splits = {given!r}; allowed: names with shares, such as train = 0.8.")
    if not math.isclose(sum(given.values()), 1.0, abs_tol=1e-6):
        raise InvalidValueError(f"{where}: the splits add up to {sum(given.values()):g}; allowed: 1. Correct them.")
    return {name: float(share) for name, share in given.items()}


def _severity(where: str, given: object) -> dict[str, tuple[str, ...]]:
    if not isinstance(given, dict) or not all(isinstance(one, list) for one in given.values()):
        raise InvalidValueError(f'{where}: allowed in severity: name = ["effect.NAME.PARAMETER", ...]. Correct it.')
    return {name: tuple(map(str, sources)) for name, sources in given.items()}


def _check_whole(where: str, recipe: Recipe) -> None:
    """Raise InvalidValueError for what no part alone shows; builds each machine once in every case."""
    from .recipe_draw import label_columns, split_of

    names = [one.name for one in recipe.machines]
    for name in names:
        if names.count(name) > 1:
            raise InvalidValueError(f"{where} has two machines {name!r}; allowed: different names. Give one a name.")
    if recipe.signals > MOST_SIGNALS:
        raise InvalidValueError(f"{where} asks for {recipe.signals} signals; allowed: {MOST_SIGNALS}. Lower draws.")
    there = {split_of(recipe, draw) for draw in range(min(recipe.draws, 10_000))}
    for name in set(recipe.splits) - there:
        raise InvalidValueError(
            f"{where}: of {recipe.draws} machine draws none falls to the split {name!r}. Raise draws or its share."
        )
    units: set[str] = set()
    for machine in recipe.machines:
        units |= _check_machine(f"{where}, machine {machine.name}", machine)
        check_tacho(
            f"{where}, machine {machine.name}",
            recipe.chain,
            speed_rpm=max(machine.speed_rpm.ends()),
            rate_hz=machine.rate_hz,
        )
    check_units(f"{where}, chain", recipe.chain, units)
    columns = label_columns(recipe)
    for name, sources in recipe.severity.items():
        for source in sources:
            if source not in columns:
                raise InvalidValueError(
                    f"{where}: severity {name} comes from {source!r}; allowed: {', '.join(columns)}. Correct it."
                )


def _check_machine(where: str, recipe: MachineRecipe) -> set[str]:
    """Return the units of what is recorded."""
    from .simulated import recordable

    size = recipe.samples * recipe.records * len(recipe.machine.bare_assembly().probes)
    if not recipe.samples >= 1 or size > MOST_SAMPLES:
        raise InvalidValueError(
            f"{where}: {recipe.duration_s:g} s at {recipe.rate_hz:g} Hz; allowed: one sample or more, and all probes "
            f"together up to {MOST_SAMPLES} samples. Change duration_s or rate_hz."
        )
    case_names, units = [case.name for case in recipe.cases], set[str]()
    for case in recipe.cases:
        if case_names.count(case.name) > 1:
            raise InvalidValueError(f"{where} has two cases {case.name!r}; allowed: different names. Rename one.")
        try:
            there = _example(recipe.machine, case).assembly(speed_rpm=recipe.speed_rpm.ends()[0]).probes
            units |= {probe.unit for probe in recordable(there, recipe.probes)[0]}
        except RotorwiseError as problem:
            raise InvalidValueError(f"{where}, case {case.name}: {problem}") from None
    return units


def _example(machine: Machine, case: Case) -> Machine:
    values = {name: choice.ends()[0] for name, choice in case.parameters.items()}
    effects = [
        make_effect(one.name, {name: choice.ends()[0] for name, choice in one.values.items()}, at=one.at)
        for one in case.effects
    ]
    return machine.with_parameters(**values).with_effects(*effects)


def _tables(where: str, entry: Mapping[str, Any], key: str, *, needed: bool = True) -> list[dict[str, Any]]:
    found = entry.get(key, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found) or (needed and not found):
        raise InvalidValueError(f"{where}: allowed: one or more tables [[{key}]]. Correct the headings.")
    return found


def _check_keys(where: str, given: Mapping[str, object], allowed: Sequence[str]) -> None:
    for key in given:
        if key not in allowed:
            known = ", ".join(one for one in allowed if one != "machine_text")
            raise InvalidValueError(f"{where} has an unknown entry {key!r}; allowed: {known}. Correct or remove it.")


def _text(where: str, given: Mapping[str, object], key: str, default: str | None = None) -> str:
    value = given.get(key, default)
    if not isinstance(value, str) or (default is None and not value) or not _is_readable(value):
        raise InvalidValueError(f"{where}: {key} = {value!r}; allowed: a text in quotes, printable. Give it.")
    return value


def _texts(where: str, given: Mapping[str, object], key: str) -> tuple[str, ...]:
    value = given.get(key, [])
    if not isinstance(value, list) or not all(isinstance(one, str) and _is_readable(one) for one in value):
        raise InvalidValueError(f"{where}: {key} = {value!r}; allowed: a list of texts, printable. Correct it.")
    return tuple(value)


def _is_readable(text: str) -> bool:
    """Return whether a text may go to a terminal: line ends are allowed, other control characters are not."""
    return text.replace("\n", "").isprintable()


def _whole(where: str, given: Mapping[str, object], key: str, *, lowest: int, default: int | None = None) -> int:
    value = given.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or not lowest <= value <= 2**53:
        raise InvalidValueError(f"{where}: {key} = {value!r}; allowed: a whole number, {lowest} to {2**53}. Give it.")
    return value


def _positive(where: str, given: Mapping[str, object], key: str) -> float:
    value = given.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e100:
        raise InvalidValueError(f"{where}: {key} = {value!r}; allowed: more than 0; there is no default. Give it.")
    return float(value)
