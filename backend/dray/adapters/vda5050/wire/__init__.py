"""What goes over the wire: one table of dialects, messages of vehicles read tolerantly, orders and instant actions written."""
