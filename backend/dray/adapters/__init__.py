"""The real world behind the ports: the computer's clock, the distributed bus."""
