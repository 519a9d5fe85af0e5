"""The headless verbs, one per file, and the texts and the picture that they give."""
