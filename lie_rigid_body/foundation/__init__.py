"""Foundation that every room may import: errors and their words, parameters, arrays, and how results are shown."""
