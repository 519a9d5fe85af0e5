"""The live node: a thin adapter of the simulation to ROS 2. Nothing outside this folder imports a ROS package.

`sim` starts the node. `node` joins `publishing`, what it sends, and `control`, what others may ask of it. Both stand on
`timing`, the loop that takes samples from the simulation when they are due. `evaluate` scores the estimate of another
node, whose messages `following` takes in bulk. `listen` is a small client.
"""
