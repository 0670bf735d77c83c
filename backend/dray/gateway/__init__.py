"""The gateway: what people and other systems reach over HTTP. A peer that listens, and never decides.

`app` puts it together out of `services`, each of which is given what it uses; `inbox` hands on what is heard on the
bus. Everything else is in rooms: README.md says what is in each, and for which panel.
"""
