"""Simulated vehicles that speak VDA 5050, for tests and demonstrations: any version, and any of its known misbehaviours.

Written from the text and the schemas, and on purpose not on what the driver in `dray.adapters.vda5050` is written on.
"""
