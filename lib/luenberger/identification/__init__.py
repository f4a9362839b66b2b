"""From a record: likelihood, identifiability, and what the noises are."""
