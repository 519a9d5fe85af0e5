"""Messages that the node sends: topics, markers, transforms, diagnostics, its bag, and the text on the terminal."""
