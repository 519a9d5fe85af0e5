"""Filters of other libraries, a file each."""
