"""The stop path: stops of vehicles, and nothing else.

All else in a gateway runs on one loop, behind one listener and a database. A stop has its own loop, listener
and connection to the bus, so that no file, slow query or crowd of connections blocks it. It shares only the
process.

    tablet -- POST --> endpoint -- authenticated from memory --> sender -- with a grant --> bus --> vehicle
                       endpoint <------ the vehicle's answer ------ sender <---------------- bus <--
                                    sender -- what was done --> recorder (on the gateway's loop: panels, audit log)

A stop sent both ways under one name is one stop: vehicles answer a repeated command as before.
"""
