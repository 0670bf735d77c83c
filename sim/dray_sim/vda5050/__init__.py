"""Simulated vehicles that speak VDA 5050, for tests and demonstrations: any version, and any of its known misbehaviours.

It is written from the text and the schemas, and deliberately shares nothing with the driver in
`dray.adapters.vda5050`.
"""
