"""Layouts of other systems: LIF of VDMA and models of openTCS, read into an unfinished plant file, and plants written as LIF.

`read` tells the formats apart, `lif` and `opentcs` read into one `TrackLayout`, `assemble` makes a plant file and a
mapping of it; `lif_export` writes. Pure: text in, text out. Reading is lenient: odd and rejected values are reported
with their places (`notes`).
"""
