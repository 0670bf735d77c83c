"""What people and agents say to one another: who is on duty, who calls for help, who commands."""
