"""What the model-gap engine says of the measured bench: python tests/measured/gap_table.py [CLASS ...] [--few].

Recordings of the Analog Devices bench at 1200, 1800 and 2400 rpm against the healthy ones of the same speeds, the rig
`test_rig adi` as model. The sensor's sensitivity is not documented: 20 mV/g is taken, so that masses may all be four
times too large. ``--few`` lets six effects compete instead of the whole catalogue, which takes minutes a row.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.campaign import find_sources, read_campaign
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.result import GapResult
from rotorwise.simulators.machine import Machine, find_machine

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import DATA, HERE

FOLDER = DATA / "01_adi_limerick_mfs" / "data"
SENSITIVITY = "20 mV/g"
PROBES = ("X=housing_b_x", "Y=housing_b_y", "Z=housing_b_axial")
SPEEDS = (1200, 1800, 2400)
HEALTHY = "GoB_GS_BaLo_WA"
#: What the files call it, the speeds at which the class was recorded here, and what it is.
CLASSES = {
    "very light imbalance": ("GoB_GS_VLIL_WA", SPEEDS),
    "light imbalance": ("GoB_GS_LImL_WA", SPEEDS),
    "heavy imbalance": ("GoB_GS_HImL_WA", SPEEDS),
    "very heavy imbalance": ("GoB_GS_VHIL_WA", SPEEDS),
    "misaligned": ("GoB_GS_BaLo_MA", SPEEDS),
    "bent shaft": ("GoB_BS_BaLo_WA", SPEEDS),
    "outer race": ("HOR_GS_BaLo_WA", (1800,)),
    "inner race": ("HIR_GS_BaLo_WA", (1800,)),
    "first halves of healthy": (HEALTHY, SPEEDS),
    "second halves of healthy": (HEALTHY, SPEEDS),
}
FEW = frozenset(
    ("unbalance", "shaft_bow", "coupling_misalignment", "looseness", "outer_race_defect", "inner_race_defect")
)


def bench() -> Machine:
    """Return the model of the bench."""
    return find_machine("test_rig").preset("adi")


def campaign(name: str) -> Campaign:
    """Return the recordings of a class, with the healthy ones of the same speeds as baseline."""
    class_name, speeds = CLASSES[name]
    kinds = [[FOLDER / f"{speed}_{kind}_00lb.Wfm.csv" for speed in speeds] for kind in (class_name, HEALTHY)]
    with tempfile.TemporaryDirectory() as place:
        sidecar = Path(place) / "recording.toml"
        text = (HERE / "adi_limerick.toml").read_text(encoding="utf-8")
        sidecar.write_text(text.replace('unit = "V"', f'unit = "V"\nsensitivity = "{SENSITIVITY}"'), encoding="utf-8")
        if "halves" not in name:
            return read_campaign(
                find_sources(kinds[0], baseline=kinds[1]), bench(), sidecar=sidecar, probes=PROBES
            ).campaign
        whole = read_campaign(find_sources(kinds[1]), bench(), sidecar=sidecar, probes=PROBES).campaign.recordings
    cuts = [(one.samples // 2, one) for one in whole]
    first = tuple(replace(one, signals=one.signals[:, :middle]) for middle, one in cuts)
    second = tuple(replace(one, signals=one.signals[:, middle:]) for middle, one in cuts)
    return Campaign(first, second) if name.startswith("first") else Campaign(second, first)


def row(name: str, answer: GapResult, seconds: float) -> str:
    """Return a row of the table."""
    causes = []
    for cause in answer.causes:
        first = next(iter(cause.parameters.items()), None)
        size = f", {first[0]} {first[1].value:.2g} ({first[1].low:.2g} to {first[1].high:.2g})" if first else ""
        causes.append(f"{cause.effect} at {cause.at} {cause.probability:.2f}{size}")
    likely = ", ".join(f"{'+'.join(names) or 'nothing'} {p:.2f}" for names, p in list(answer.probabilities.items())[:3])
    return f"| {name} | {answer.kind} | {'; '.join(causes)} | {likely} | {seconds:.0f} |"


def main() -> None:
    """Print the table, a row as soon as it is known."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("classes", nargs="*", default=list(CLASSES))
    asked.add_argument("--few", action="store_true")
    given = asked.parse_args()
    unknown = [name for name in given.classes if name not in CLASSES]
    if unknown:
        asked.error(f"no class {', '.join(unknown)}; there are {', '.join(CLASSES)}")
    print("| recorded | verdict | causes | hypotheses | CPU s |\n|---|---|---|---|---|", flush=True)
    for name in given.classes:
        start = time.process_time()
        answer = explain_gap(campaign(name), bench(), only=FEW if given.few else None)
        print(row(name, answer, time.process_time() - start), flush=True)


if __name__ == "__main__":
    main()
