"""The wire: one table of dialects, tolerant reading of vehicles' messages, writing of orders and instant actions."""
