"""The live node: a thin adapter of the simulation to ROS 2. Nothing outside this folder knows ROS."""
