"""The stop path: stops of vehicles, and nothing else.

Everything else that a gateway does happens on one loop, behind one listener, with the database behind it. A stop
has a loop, a listener and a place on the bus of its own, so that nothing of the rest can be in its way: no file that
is read, no slow query, no crowd of connections. It shares the process, and no more than that.

    tablet -- POST --> endpoint -- authenticated from memory --> sender -- with a grant --> bus --> vehicle
                       endpoint <------ the vehicle's answer ------ sender <---------------- bus <--
                                    sender -- what was done --> recorder (on the gateway's loop: panels, audit log)

A stop that is sent both ways under one name is one stop: vehicles answer a command that comes again as before.
"""
