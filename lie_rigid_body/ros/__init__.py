"""The live node: a thin adapter of the simulation to ROS 2. Nothing outside this folder imports a ROS package.

`sim`, `evaluate` and `listen` are command lines, read without ROS. `node` is that of the first, and joins
`publishing`, what it sends, and `control`, what others may ask of it. Both stand on `timing`, the loop that takes
samples from the simulation when they are due. `evaluator` scores the estimate of another node, whose messages
`following` takes in bulk. `client` asks the node of `sim`.
"""
