"""Commands for administrators of a plant: people, keys, links, certificates, the database, exclusions."""
