"""Machines and docks whose sensors and controllers publish single values on topics of an MQTT broker."""
