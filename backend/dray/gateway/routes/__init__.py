"""Routers, one per noun. They define requests and answers, and leave the rest to the rooms below.

`table` lists them all. Here: the present state and people's actions. `orders`: orders, files of them, and the
customers' view; `history`: the past, from SQL; `pages`: pages for browsers; `openapi`: the document of all.
"""
