"""Products as people write them: in a form, a request, or a spreadsheet."""
