"""The operating system: bounded input, files that appear whole, locks, processes, signals and the terminal."""
