"""What the model says of measured faults that its training lacks: python tests/measured/unseen_faults.py [--write].

For each fault that measured recordings show, the default model's training without it. "unknown" or nothing is the right
answer there; another fault's name is not. With ``--write`` the table in diagnose/learning/README.md is made again.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from rotorwise.diagnose.learning.default_model import FEATURES, MODEL, SEED
from rotorwise.diagnose.learning.fault_classifier import FaultClassifier
from rotorwise.diagnose.learning.feature_file import read_features
from rotorwise.diagnose.learning.learning_set import learnable, learning_set
from rotorwise.diagnose.learning.training import UNKNOWN_BELOW

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import DATA
from learning_table import README, Seen, seen

SHIPPED = README.parent / FEATURES
BEGIN, END = "<!-- unseen table -->", "<!-- end of unseen table -->"
KINDS = ("the fault", "unknown", "nothing", "another fault")


def said(classifier: FaultClassifier, one: Seen) -> str:
    """Return which kind of answer a recording gets."""
    values = one.values[None, :]
    name = str(classifier.predict(values)[0])
    if float(classifier.novelty_p_value(values)[0]) < UNKNOWN_BELOW:
        return "unknown"
    if name == one.truth:
        return "the fault"
    return "nothing" if name == "healthy" else "another fault"


def table(recordings: list[Seen]) -> str:
    """Return the table in Markdown."""
    rows = learnable(learning_set(read_features(SHIPPED)[0], seed=SEED))
    shown = sorted({one.truth for one in recordings if one.visible and one.truth != "healthy"})
    lines = ["| fault | training | recordings | " + " | ".join(KINDS) + " |", "|---|---|--:|" + "--:|" * len(KINDS)]
    for fault in shown:
        own = [one for one in recordings if one.visible and one.truth == fault]
        for training, kept in (("with it", rows), ("without it", rows.where(rows.labels != fault))):
            fitted = FaultClassifier(model=MODEL, random_state=SEED).fit(kept.values, kept.labels, groups=kept.groups)
            counts = Counter(said(fitted, one) for one in own)
            cells = " | ".join(str(counts[kind]) for kind in KINDS)
            lines.append(f"| {fault} | {training} | {len(own)} | {cells} |")
    return "\n".join(lines)


def main() -> None:
    """Print the table; rewrite the part of the README between the marks where asked."""
    if not DATA.is_dir():
        sys.exit(f"{DATA} is not there: the measured recordings are needed to make the table.")
    made = table(seen())
    print(made)
    if "--write" in sys.argv[1:]:
        text = README.read_text(encoding="utf-8")
        before, after = text[: text.index(BEGIN)], text[text.index(END) :]
        README.write_text(f"{before}{BEGIN}\n{made}\n{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
