"""Orders and their progress: orders with their lines, goals and links, placed together with their audit lines and keys."""
