"""The headless verbs, one per file, and the work of those that do much."""
