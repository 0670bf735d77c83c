"""Tracking: what a customer may know of an order, and how it is put into words.

`facts` gathers it from SQL and from the projection, `eta`, `reasons` and `track` compute from it without
any input of their own, `page` and `texts` say it in the reader's language. What has no field in `Track`
cannot leave: no machine, vehicle, place or person has one.
"""
