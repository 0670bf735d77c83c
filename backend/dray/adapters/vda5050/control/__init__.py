"""The master of one vehicle, pure: no clock, no network, no log."""
