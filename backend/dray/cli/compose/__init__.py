"""`dray compose`: a plant as containers, with TLS between them and notes that outlive an update.

The file that it writes for the default plant stands in the repository; a test compares the two.
"""
