"""Commands for whoever runs a plant: who may log in, keys, links, certificates, the database, who is shut out."""
