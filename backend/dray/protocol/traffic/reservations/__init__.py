"""Who holds which place: the reservation tables that machines keep."""
