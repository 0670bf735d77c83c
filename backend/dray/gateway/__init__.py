"""The gateway: what people and other systems reach over HTTP. A peer that listens, and never decides.

`app` puts it together; `peer` is its place on the bus; `projection` makes of messages what panels
see and `stream` sends it to browsers; `desk` brings orders to the strategist and `commands` a
person's commands to vehicles; `routes` has one router per noun; `problems` says what went wrong.
"""
