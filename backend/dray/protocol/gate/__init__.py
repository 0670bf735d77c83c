"""The gate of the delivery warehouses: counts what arrives, and lets one strategist hold each order."""
