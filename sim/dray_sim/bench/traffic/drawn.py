"""Random floors with dead ends, bridges and one-way loops; docks and parking places are on spurs.

`dray plant check` finds nothing too narrow on them, and a way leads from every node to every other one.
"""

from __future__ import annotations

from itertools import count
from random import Random

from dray.plant import Plant
from dray.plant.planning.advice_floor import floor_advice
from dray_sim.bench.traffic.plants import spurred

PITCH_M, SPUR_M = 5.0, 2.5
"""Distance between two nodes of a road, and from a node to its dock."""

COLUMNS, ROWS = (3, 8), (2, 6)

MORE_LANES = (0.0, 0.1, 0.3, 0.7)
"""Fractions of the possible lanes that are added to the spanning tree. At 0 every lane is a bridge."""

LOOPS = 3
"""Maximum number of one-way loops."""

LEAST_DOCKS = 5

NODES_PER_VEHICLE = 3

Cell = tuple[int, int]
Ends = tuple[Cell, Cell]

STEPS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))


def drawn(seed: int) -> Plant:
    """The floor of a seed; the same in every process."""
    for attempt in count():
        plant = _draw(Random(f"{seed} floor {attempt}"), f"drawn-{seed}")
        if plant is not None and not list(floor_advice(plant)):
            return plant
    raise AssertionError


def _draw(random: Random, name: str) -> Plant | None:
    """One attempt; None if it has too few sites for docks, or a node that cannot be reached or left."""
    columns, rows = random.randint(*COLUMNS), random.randint(*ROWS)
    cells = [(x, y) for x in range(columns) for y in range(rows)]
    lanes = _lanes(random, cells)
    one_way = _loops(random, cells, lanes)
    spurs = _spurs(random, cells, lanes)
    vehicles = random.randint(2, max(len(cells) // NODES_PER_VEHICLE, 2))
    if len(spurs) < LEAST_DOCKS + vehicles:
        return None
    docks = random.randint(LEAST_DOCKS, len(spurs) - vehicles)
    plant = spurred(
        name,
        {_name(cell): _spot_m(cell) for cell in cells},
        [(_name(start), _name(end)) for start, end in sorted(lanes)],
        {(_name(start), _name(end)) for start, end in one_way},
        [(_name(cell), _spur_m(cell, step)) for cell, step in spurs[:docks]],
        [(_name(cell), _spur_m(cell, step)) for cell, step in spurs[docks : docks + vehicles]],
        ((columns + 1) * PITCH_M, (rows + 1) * PITCH_M),
    )
    here = next(iter(plant.nodes))
    everywhere = set(plant.nodes)
    there = plant.roads.reached_from(here) == everywhere == plant.roads.reaching(here)
    return plant if there else None


def _lanes(random: Random, cells: list[Cell]) -> set[Ends]:
    """A spanning tree of all cells, and a random fraction of the other possible lanes."""
    possible = [
        (cell, (cell[0] + dx, cell[1] + dy))
        for cell in cells
        for dx, dy in STEPS[:2]
        if (cell[0] + dx, cell[1] + dy) in cells
    ]
    random.shuffle(possible)
    part = {cell: cell for cell in cells}

    def part_of(cell: Cell) -> Cell:
        while part[cell] != cell:
            cell = part[cell]
        return cell

    more = random.choice(MORE_LANES)
    lanes = set()
    for start, end in possible:
        one, other = part_of(start), part_of(end)
        if one != other or random.random() < more:
            lanes.add((start, end))
            part[one] = other
    return lanes


def _loops(random: Random, cells: list[Cell], lanes: set[Ends]) -> set[Ends]:
    """One-way rings of four lanes each. The lanes of a ring are turned in `lanes`, which is changed."""
    one_way: set[Ends] = set()
    for x, y in random.sample(cells, min(random.randint(0, LOOPS), len(cells))):
        ring = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        if random.random() < 0.5:
            ring.reverse()
        around = list(zip(ring, ring[1:] + ring[:1], strict=True))
        there = [{ends, ends[::-1]} & lanes for ends in around]
        if all(there) and not any({ends, ends[::-1]} & one_way for ends in around):
            for ends, before in zip(around, there, strict=True):
                lanes -= before
                lanes.add(ends)
                one_way.add(ends)
    return one_way


def _spurs(random: Random, cells: list[Cell], lanes: set[Ends]) -> list[tuple[Cell, Cell]]:
    """Sites for docks and parking places: each a node, and a side of it without a lane."""
    sides = [(cell, step) for cell in cells for step in STEPS]
    random.shuffle(sides)
    taken: set[tuple[Cell, Cell]] = set()
    used: set[Cell] = set()
    for cell, (dx, dy) in sides:
        beyond = (cell[0] + dx, cell[1] + dy)
        is_free = (cell, beyond) not in lanes and (beyond, cell) not in lanes
        if is_free and cell not in used and (beyond, (-dx, -dy)) not in taken:
            taken.add((cell, (dx, dy)))
            used.add(cell)
    found = sorted(taken)
    random.shuffle(found)
    return found


def _name(cell: Cell) -> str:
    return f"n{cell[0]}_{cell[1]}"


def _spot_m(cell: Cell) -> tuple[float, float]:
    return PITCH_M * (cell[0] + 1), PITCH_M * (cell[1] + 1)


def _spur_m(cell: Cell, step: Cell) -> tuple[float, float]:
    x_m, y_m = _spot_m(cell)
    return x_m + SPUR_M * step[0], y_m + SPUR_M * step[1]
