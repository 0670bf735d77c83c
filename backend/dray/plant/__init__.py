"""The plant: what stands where, and how to get from one place to another.

`model` holds the shapes of a plant file, `file` reads and checks it, `routes` finds ways.
"""
