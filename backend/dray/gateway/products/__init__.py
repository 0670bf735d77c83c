"""Products as written by people: in a form, a request, or a spreadsheet."""
