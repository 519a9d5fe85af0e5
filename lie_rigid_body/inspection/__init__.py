"""Inspection of a log of gyro, accelerometer and magnetometer: what is wrong with it, without a truth.

A vector that is constant in the world obeys dv/dt = −ω × v in the body, so that the sensors judge each other.

- `rule`: all numbers by which something is named, and the hypotheses that are tried;
- `stamps`: what needs no model;
- `world`: how constant a vector is in the world that the gyro integrates;
- `minimum`: where a squared misfit is least, with its standard error;
- `search`: gyros, turns and delays; `explanations`: the few repairs that explain all sensors, and the rule;
- `constants`: factor, delays, bias, hard and soft iron with standard errors, size and unit;
- `noise`: densities by the Allan deviation; `against_truth`: the clock and the mounting of a truth;
- `comparison`, `sentences`: these in order, and what is said; `findings`: what is said as data;
- `inspection`: the whole, and the run with its mistakes undone.
"""

from lie_rigid_body.inspection.findings import Estimated, LogMistake, LogNote, Mark, Undecided
from lie_rigid_body.inspection.inspection import Inspection, inspect

__all__ = ["Estimated", "Inspection", "LogMistake", "LogNote", "Mark", "Undecided", "inspect"]
