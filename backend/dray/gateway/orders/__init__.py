"""Customers' orders, from a draft to the strategist's last answer (paper, 3.2, strategical layer).

In: `drafts`, `csv_import`, `feasibility`, `placement` under an `idempotency` key. Later: people's `actions`.
To the strategist: `outbox`; its answers: `completions`; possibly lost messages: `reconciliation`. Everything
is in SQL before it is announced.
"""
