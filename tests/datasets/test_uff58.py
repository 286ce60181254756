"""Names of channels in data sets 58: entity, else node, else or better what the first record says."""

import pytest
from rotorwise.datasets.readers import uff58

SET = """    -1
    58
{said:<80}
NONE
01-Jan-26 00:00:00
NONE
NONE
    1         0    0         0 {entity:<10}{node:>10}{direction:>4} NONE               0   0
         2         8         1  0.00000e+00  1.00000e-03  0.00000e+00
        17    0    0    0 Time                 s
        12    0    0    0 Response             m/s2
         0    0    0    0 NONE                 NONE
         0    0    0    0 NONE                 NONE
{values}
    -1
"""
VALUES = "\n".join("".join(f"{0.1 * k + j:13.5e}" for j in range(4)) for k in range(2))


def written(tmp_path, *sets):
    path = tmp_path / "a.uff"
    path.write_text(
        "".join(
            SET.format(said=said, entity=entity, node=node, direction=1 + number, values=VALUES)
            for number, (said, entity, node) in enumerate(sets)
        )
    )
    return list(uff58.read(path).channel_names)


@pytest.mark.parametrize(
    ("sets", "names"),
    [
        ([("Brg A Hor", "NONE", 1), ("Brg A Ver", "NONE", 1)], ["Brg A Hor", "Brg A Ver"]),
        ([("Brg A Hor", "DE", 1), ("Brg A Ver", "NDE", 1)], ["DE", "NDE"]),
        ([("test 7", "NONE", 1), ("test 7", "NONE", 1)], ["node 1+X", "node 1+Y"]),
        ([("NONE", "NONE", 3), ("Brg B", "NONE", 4)], ["node 3+X", "node 4+Y"]),
        ([("Brg A", "NONE", 0)], ["Brg A"]),
    ],
)
def test_names(tmp_path, sets, names):
    assert written(tmp_path, *sets) == names
