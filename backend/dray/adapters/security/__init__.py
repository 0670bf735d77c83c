"""Identities and authorship: certificates and their revocation, seals of messages, letters, signatures of grants."""
