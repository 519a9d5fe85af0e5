"""The loop of the live node: when each sample is due, who receives it, and which calls are carried out in between."""
