"""Tables and a model that the tests of severities share."""

from dataclasses import dataclass

import pytest
from rotorwise.datasets.recipe_file import load_recipe
from rotorwise.datasets.store import Store
from rotorwise.datasets.store_folder import LocalFolder
from rotorwise.diagnose.learning.severity.model import SeverityModel, fit_model
from rotorwise.diagnose.learning.severity.reading import SeverityTable, probes_of, reference_machine
from rotorwise.diagnose.learning.severity.unit_responses import UnitResponses

from .drawn_machines import drawn_table


@dataclass(frozen=True)
class Trained:
    """A model, and machines that it has not seen."""

    model: SeverityModel
    held_out: SeverityTable


@pytest.fixture(scope="session")
def responses() -> UnitResponses:
    recipe = load_recipe("severity_amb_rotor")
    return UnitResponses(reference_machine(recipe), probes_of(recipe))


@pytest.fixture(scope="session")
def trained(tmp_path_factory, responses) -> Trained:
    recipe = load_recipe("severity_amb_rotor")
    table = drawn_table(recipe, responses, draws=range(40), per_draw=4, seed=1)
    store = Store(LocalFolder(tmp_path_factory.mktemp("store")), recipe, "0")
    model = fit_model(table, responses, store=store, split=None, coverage=0.9, seed=0)
    # One record a machine: hits are then independent.
    return Trained(model, drawn_table(recipe, responses, draws=range(60, 120), per_draw=1, seed=2))
