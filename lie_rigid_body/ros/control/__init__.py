"""Requests of other nodes to the simulator: parameters, services, and the standard simulator services."""
