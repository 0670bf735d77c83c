"""An operator on duty: visible to others, asked for help, and answering by the person's decisions."""
