"""Routers, one per noun. They say what a request and its answer look like, and leave the rest to the rooms below.

`table` lists them all. Here: what there is at this moment and what people do about it. `orders`: orders and files of them, and their
customers' view; `history`: what has happened, from SQL; `pages`: what a browser shows; `openapi`: the document of it all.
"""
