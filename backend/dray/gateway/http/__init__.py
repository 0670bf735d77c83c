"""Parts of any REST service: problems, bodies, responses, tables, middleware, page files and languages.

Independent of factories. `provided` gives routers and middleware the running gateway's services.
"""
