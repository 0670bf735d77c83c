"""What any REST service has: problems, bodies, responses, tables, middleware, the pages' files and languages.

Knows nothing of factories. `provided` is how routers and middleware get at the services of the running gateway.
"""
