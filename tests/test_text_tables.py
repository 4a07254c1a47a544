"""Text tables: no line is wider than asked, no cell is lost, groups of columns stay together."""

import re

from hypothesis import given
from hypothesis import strategies as st

from proxemetry.text_tables import Columns, in_blocks

CELL = st.text("0123456789.", min_size=1, max_size=9)


@st.composite
def tables(draw):
    count = draw(st.integers(1, 4))
    keys = Columns("", ("name",), tuple((f"row{k}",) for k in range(count)))
    groups = []
    for number in range(draw(st.integers(1, 7))):
        heads = tuple(f"h{number}{k}" for k in range(draw(st.integers(1, 3))))
        rows = tuple(tuple(draw(CELL) for _ in heads) for _ in range(count))
        groups.append(Columns(draw(st.sampled_from(["", f"title{number}"])), heads, rows))
    return keys, groups


@given(tables(), st.integers(50, 120))
def test_every_cell_stands_once_in_its_row_and_under_its_head(table, width):
    keys, groups = table
    lines = in_blocks(keys, groups, width)
    assert max(map(len, lines)) <= width
    assert all(line == line.rstrip() for line in lines)
    for k, (name,) in enumerate(keys.rows):
        found = [cell for line in lines if line.startswith(name) for cell in line.split()[1:]]
        assert found == [cell for group in groups for cell in group.rows[k]]
    heads = [cell for line in lines if line.startswith("name") for cell in line.split()[1:]]
    assert heads == [head for group in groups for head in group.heads]
    assert re.findall(r"title\d", "\n".join(lines)) == [group.title for group in groups if group.title]


def test_a_table_by_hand():
    keys = Columns("", ("mm", "photos"), (("16", "11"), ("105", "25")))
    one = Columns("scene", ("rate", "%"), (("1.00", "20.2"), ("0.95", "26.7")))
    other = Columns("longer name", ("%",), (("9.1",), ("-",)))
    assert in_blocks(keys, [one, other], 40) == [
        "                scene      longer name",
        "mm   photos   rate     %             %",
        "16   11       1.00  20.2           9.1",
        "105  25       0.95  26.7             -",
    ]
    assert in_blocks(keys, [one, other], 30) == [
        "                scene",
        "mm   photos   rate     %",
        "16   11       1.00  20.2",
        "105  25       0.95  26.7",
        "",
        "              longer name",
        "mm   photos             %",
        "16   11               9.1",
        "105  25                 -",
    ]
