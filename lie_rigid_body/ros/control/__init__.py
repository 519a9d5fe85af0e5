"""What other nodes may ask of the simulator: parameters, services, and the standard simulator services."""
