"""The reservation tables that machines keep: which vehicle holds which place."""
