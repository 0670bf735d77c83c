"""What was ordered, and how far it is: orders with their lines, goals and links, placed with what came beside them."""
