"""The gate of the delivery warehouses: it counts arrivals, and lets one strategist hold each order."""
