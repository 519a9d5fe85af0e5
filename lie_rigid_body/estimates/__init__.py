"""Estimates of an attitude, however they come, beside the run that they are of.

- `estimators`, `programs`: from functions of a run, and from programs and nodes that are called as such;
- `recorded_estimate`: from a bag, with its truth;
- `live_estimate`: from topics, message by message;
- `buffers`: its attitudes and biases, and those of its truth, as they come, and which of them a score can use.
"""
