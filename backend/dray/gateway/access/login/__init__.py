"""The login: pages, secrets, links and cookies, and where somebody goes afterwards.

`login` finds the person to what is shown; `page` and `texts` say it in the visitor's language; `hasher` and `secrets`
are what is kept and what is good enough; `redirect` leads on to a page of ours, and never elsewhere.
"""
