"""Machines and docks whose sensors and controllers say single values on topics of an MQTT broker."""
