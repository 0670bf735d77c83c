"""An index by which the orders of a product are found: a removed product that no order names is forgotten.

Revision: 0045, after 0044
"""

from __future__ import annotations

from alembic import op

revision = "0045"
down_revision = "0044"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_index("ix_order_items_product", "order_items", ["product"])


def downgrade() -> None:
    op.drop_index("ix_order_items_product", "order_items")
