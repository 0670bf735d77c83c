"""The login: pages, secrets, links and cookies, and the redirect afterwards.

`login` finds the person for a secret; `page` and `texts` show pages in the visitor's language; `hasher` and
`secrets` hash and check secrets; `redirect` leads on to our own pages only.
"""
