"""Who holds which place: the books that machines keep."""
