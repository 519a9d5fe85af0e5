"""The headless verbs, one per file."""
