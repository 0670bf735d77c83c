"""`dray compose`: a plant as containers, with TLS between them and journals that outlive an update.

The repository contains its file for the default plant; a test compares the two.
"""
