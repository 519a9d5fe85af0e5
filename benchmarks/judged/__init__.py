"""Physics engines, and integrators of our own with mistakes put in, as `lie_rigid_body.conformance.judge` runs them."""
