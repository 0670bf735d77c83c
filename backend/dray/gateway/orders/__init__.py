"""Orders of customers, from a draft to the strategist's last word on them (paper, 3.2, strategical layer).

In: `drafts`, `csv_import`, `feasibility`, `placement` under an `idempotency` key. Later: `actions` of people. To the
strategist: `outbox`; what it answers: `completions`; what may have been missed: `reconciliation`. All of it is in SQL
before anybody is told.
"""
