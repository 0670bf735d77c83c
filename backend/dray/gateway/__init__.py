"""The gateway: access for people and other systems over HTTP. A peer that listens, and never decides.

`app` puts it together from `services`, each of which gets what it uses; `inbox` dispatches messages from the
bus. Everything else is in rooms: README.md lists them, and their panels.
"""
