"""Tracking: what a customer may know of an order, in words.

`facts` reads SQL and the projection; `eta`, `reasons` and `track` compute from that alone; `page` and `texts`
phrase it in the reader's language. Data without a field in `Track` cannot leak: machines, vehicles, places
and people have none.
"""
