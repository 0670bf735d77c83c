"""The paper's own cases and experiments: section 4.2, cases 1 to 6, and section 4.3 with Figure 6."""
