"""From probabilities to the verdict."""

import pytest
from rotorwise.diagnose.gap.judged import judged

BOW, UNBALANCE, UNKNOWN = ("shaft_bow",), ("unbalance",), ("unknown",)
BOTH, BESIDE, BOW_BESIDE = ("shaft_bow", "unbalance"), ("unbalance", "unknown"), ("shaft_bow", "unknown")


@pytest.mark.parametrize(
    ("probabilities", "kind", "leading", "together"),
    [
        ({(): 0.9, UNBALANCE: 0.1}, "none", (), [()]),
        ({(): 0.4, UNBALANCE: 0.3, BOW: 0.3}, "cannot tell", (), [()]),
        ({UNBALANCE: 0.7, BOW: 0.29, (): 0.01}, "one cause", UNBALANCE, [UNBALANCE, BOW]),
        ({BOTH: 0.99, UNBALANCE: 0.01}, "several causes", BOTH, [BOTH]),
        ({UNBALANCE: 0.3, (): 0.28, UNKNOWN: 0.42}, "cannot tell", UNKNOWN, [UNKNOWN]),
        ({UNKNOWN: 0.8, UNBALANCE: 0.2}, "unknown", UNKNOWN, [UNKNOWN]),
        # An effect beside something unknown is named only where it is nearly certain that one acts.
        ({BESIDE: 0.8, BOW_BESIDE: 0.195, UNKNOWN: 0.005}, "unknown", BESIDE, [BESIDE, BOW_BESIDE]),
        ({BESIDE: 0.97, UNKNOWN: 0.03}, "unknown", UNKNOWN, [UNKNOWN]),
        ({BESIDE: 0.45, (): 0.4, UNKNOWN: 0.15}, "unknown", UNKNOWN, [UNKNOWN]),
    ],
)
def test_verdict(probabilities, kind, leading, together) -> None:
    assert judged(probabilities) == (kind, leading, together)
