"""The invariants of docs/protocol.md, checked while a run goes on. A check hears everything and takes no part."""
