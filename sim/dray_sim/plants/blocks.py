"""A floor of equal blocks between lanes: the road network of a generated plant.

Blocks are counted row by row from the lower left. Places in a block have docks on short spurs of the lane below or
above it, so that a docked vehicle blocks no lane. Two spurs that leave a lane at one spot share its node.
"""

from __future__ import annotations

from itertools import pairwise

from dray.plant import Lane, Node

BLOCK_WIDTH_M, BLOCK_HEIGHT_M = 10.0, 7.5
"""Lane to lane, as in the default plant."""

MARGIN_M = 3.0
"""Distance from the outermost lanes to the walls."""

SPUR_SPEED_MPS = 0.8
"""People work beside the spurs."""


class Blocks:
    """Nodes and lanes of a floor, growing as places are docked.

    Args:
        columns: blocks side by side.
        rows: blocks one above the other.
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self.width_m = columns * BLOCK_WIDTH_M + 2 * MARGIN_M
        self.height_m = rows * BLOCK_HEIGHT_M + 2 * MARGIN_M
        self._docks: list[Node] = []
        self._spurs: list[Lane] = []
        self._in_lane: list[dict[float, Node]] = [{} for _ in range(rows + 1)]
        """Row of lanes -> x_m -> the node there."""
        for row in range(rows + 1):
            for column in range(columns + 1):
                self._lane_node(row, MARGIN_M + column * BLOCK_WIDTH_M)

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Nodes of the lanes, row by row, then docks in the order in which they were made."""
        return (*(node for nodes in self._in_lane for _, node in sorted(nodes.items())), *self._docks)

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """Lanes along the rows, along the columns, and spurs."""
        rows = [[node for _, node in sorted(nodes.items())] for nodes in self._in_lane]
        along = [Lane(a.id, b.id, both_ways=True) for nodes in rows for a, b in pairwise(nodes)]
        upward = [
            Lane(low[x_m].id, high[x_m].id, both_ways=True)
            for low, high in pairwise(self._in_lane)
            for x_m in (MARGIN_M + column * BLOCK_WIDTH_M for column in range(self.columns + 1))
        ]
        return (*along, *upward, *self._spurs)

    def corner_m(self, block: int) -> tuple[float, float]:
        """The lower left crossing of a block, as (x_m, y_m)."""
        row, column = divmod(block, self.columns)
        return MARGIN_M + column * BLOCK_WIDTH_M, MARGIN_M + row * BLOCK_HEIGHT_M

    def dock(self, block: int, node: str, x_m: float, y_m: float) -> str:
        """Add a dock with a spur from the nearer of the lanes below and above.

        Args:
            block: index of the block.
            node: id of the dock's node.
            x_m: from the block's left lane.
            y_m: from the block's lower lane.

        Returns:
            `node`.
        """
        above = y_m > BLOCK_HEIGHT_M / 2
        beside = self._beside(block, x_m, above=above)
        self._add_dock(block, node, x_m, y_m)
        self._spurs.append(Lane(beside.id, node, SPUR_SPEED_MPS, both_ways=True, two_lanes=False))
        return node

    def drive_through(self, block: int, node: str, x_m: float, y_m: float, half_m: float) -> str:
        """Add a dock that is entered on its left and left on its right, from the lane below.

        Args:
            block: index of the block.
            node: id of the dock's node.
            x_m: from the block's left lane.
            y_m: from the block's lower lane.
            half_m: how far to the left and right of the dock its spurs meet the lane.

        Returns:
            `node`.
        """
        way_in, way_out = (self._beside(block, x_m + side_m, above=False) for side_m in (-half_m, half_m))
        self._add_dock(block, node, x_m, y_m)
        self._spurs.append(Lane(way_in.id, node, SPUR_SPEED_MPS))
        self._spurs.append(Lane(node, way_out.id, SPUR_SPEED_MPS))
        return node

    def _add_dock(self, block: int, node: str, x_m: float, y_m: float) -> None:
        left_m, low_m = self.corner_m(block)
        self._docks.append(Node(node, left_m + x_m, low_m + y_m))

    def _beside(self, block: int, x_m: float, *, above: bool) -> Node:
        """The node in the lane below or above a block, `x_m` from its left."""
        return self._lane_node(block // self.columns + above, self.corner_m(block)[0] + x_m)

    def _lane_node(self, row: int, x_m: float) -> Node:
        nodes = self._in_lane[row]
        if x_m not in nodes:
            nodes[x_m] = Node(f"r{row}_{len(nodes)}", x_m, MARGIN_M + row * BLOCK_HEIGHT_M)
        return nodes[x_m]
