"""An operator on duty: is there for others to see, is asked for help, and answers what the person decides."""
