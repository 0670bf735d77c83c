"""The simulated network: WLAN with its access points, vehicles' modems and radios, and their faults."""
