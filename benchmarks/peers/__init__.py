"""This package and what one would otherwise use, each asked for the attitudes of one free body."""
