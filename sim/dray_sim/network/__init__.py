"""The simulated network: WLAN with its access points, vehicles' modems and radios, and what can go wrong there."""
