"""The station agent of a storage."""
