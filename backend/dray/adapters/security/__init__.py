"""Who is who, and who has said what: certificates and their revocation, seals of messages, letters, signatures of grants."""
