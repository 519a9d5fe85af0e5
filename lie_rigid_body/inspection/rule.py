"""Numbers of the rule by which a mistake is named, each with its source, and the hypotheses that are tried.

"Measured" means measured on recordings of sensors in a hand with optical truth (BROAD, doi 10.3390/data6070072) and on
simulated ones. `benchmarks/inspection.py` measures them again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS
from lie_rigid_body.foundation.arrays import Array

# --- what is named -------------------------------------------------------------------------------------------------
TOLD_APART: Final = 1.6
"""Ratio of misfits up to which two explanations fit equally well: healthy recordings have up to 1.54."""
EXCLUDED: Final = 2.5
"""Ratio of misfits from which an explanation is excluded: where something was wrong, "nothing" had 2.49 and more."""
MAX_ALTERNATIVES: Final = 3
"""Largest number of explanations that are told beside each other: any one of three frames may be the wrong one."""
MIN_DELAY_S: Final = 0.025
"""Least delay that is a mistake, s: healthy recordings have 3 to 13 ms of their own."""
SAME_DELAY_S: Final = 0.05
"""Largest difference of two delays that are one of the gyro, in the search, s; a step of its scan is 0.04 s."""
MIN_LOG_FACTOR: Final = 0.08
"""Least logarithm of a factor of the gyro that is a mistake: healthy recordings have 0.03 at most."""
MIN_HARD_IRON: Final = 0.2
"""Least hard iron that is told, as a share of the field."""
SIGMAS: Final = 4.0
"""Number of standard errors that a constant must exceed."""
MIN_GAIN: Final = 1.25
"""Least ratio of the misfit without a constant to that with it."""
MAX_MISFIT: Final = 0.25
"""Misfit, as a share of the vector, above which no hypothesis explains a sensor: wrong gyros leave 0.3 and more."""

# --- what a misfit is ----------------------------------------------------------------------------------------------
MIN_MISFIT: Final = 0.004
"""Misfit below which a fit is perfect, as a share of the vector: what calibrated sensors leave."""
BIAS_COST: Final = (0.01 / np.radians(5.0)) ** 2
"""Squared misfit that a bias of the gyro of 1 rad/s costs: 5°/s cost 1 % of the vector."""
OFFSET_COSTS: Final = {"accelerometer": 0.2**2, "magnetometer": 0.003**2}
"""Squared misfits that offsets as large as the vectors cost. An attached magnet is nearly free. An accelerometer has
small ones only, or a log that only yaws has no rotation."""
LENGTHS_S: Final = (0.5, 2.0, 8.0)
"""Lengths of the Hann windows, s: spins need short ones, slow rotations long ones."""
BLOCK_S: Final = 1.0 / 16.0
"""Time over which products of readings are averaged before the windows, s."""
MAX_STEPS: Final = 200
"""Number of steps between windows from which some are left out."""
MIN_LENGTHS: Final = 5.5
"""Least duration of a log in lengths of the windows: those of ten of them."""
MIN_SHARE_LEFT: Final = 0.4
"""Least share of the vector that windows leave: longer ones than a spin leave nothing, and wrong gyros fit best."""
MAX_ROTATION_DEG: Final = 20.0
"""Largest rotation between readings, at nine in ten, that a gyro can follow: walks at 2 Hz had false names above it."""
MAX_SPAN_NS: Final = 150 * 10**9
"""Longest stretch that is compared with models, ns: the one that turns most about its least axis."""

# --- hypotheses ----------------------------------------------------------------------------------------------------
TURNS: Final[Array] = SIGNED_PERMUTATIONS[np.linalg.det(SIGNED_PERMUTATIONS) > 0.0]
"""Proper rotations that permute axes, the first of which is the identity, shape (24, 3, 3). A vector's sign is not
told, so that those of determinant −1 are the same."""


RIGHT: Final = 1.0
"""Multiplier of a gyro without mistake. Every hypothesis about the gyro is a multiplier: of what it reads, by sign and
factor, to the true rate."""
GYRO_UNITS: Final = {"": 1.0, "× π/180": np.pi / 180.0, "× 180/π": 180.0 / np.pi}
"""Factors of the gyro that are those of units, by their repairs."""
GYROS: Final = tuple(
    sign * factor
    for factor in (*GYRO_UNITS.values(), *(2.0 ** (k / 4.0) for k in range(-8, 9) if k))
    for sign in (1.0, -1.0)
)
"""Multipliers of the first screening: units, and quarter octaves up to four octaves."""
DELAYS_S: Final = (0.0, -0.02, 0.02, *(sign * 0.04 * k for k in range(1, 9) for sign in (1, -1)))
"""Delays of the scan, s; the first three are none."""
MAX_DELAY_S: Final = max(DELAYS_S)
"""Longest of them, s."""
REFINED_LOG_FACTOR: Final = 0.02
"""Change of the logarithm of a factor, fitted to one vector, from which it is a hypothesis of its own. A factor that is
10 % off the grid does not fit fast rotations."""
MAX_LOG_FACTOR_ERROR: Final = 0.05
"""Standard error of that logarithm up to which it is."""

# --- constants that are fitted ---------------------------------------------------------------------------------------
CHUNKS: Final = 10
"""Number of successive parts of a log whose scatter tells standard errors."""
DELAY_STEP_S: Final = 0.02
"""Step at which the squared misfit is compared to find a delay, s."""
FINE_DELAY_STEP_S: Final = 0.01
"""This step after one for the factor, s."""
LOG_FACTOR_STEPS: Final = (0.1, 0.03)
"""Steps at which the squared misfit is compared to find the logarithm of a factor."""
MAX_NEWTON_STEPS: Final = 5
"""Largest number of steps toward a minimum, each at most as long as those."""
UNSEEN_SHARE: Final = 0.75
"""Share of the misfit that a delay must make to be seen: its squared misfit grows by 1.25² − 1 = 0.75²."""
MIN_UNSEEN_S: Final = 0.03
"""Difference of two delays up to which they are one of the gyro, s, if the log sees each as sharply."""
DIM_DELAY_S: Final = 0.05
"""Delay up to which one must be seen, s: where it is not, the log does not decide."""
INDEPENDENT_STEPS: Final = 20.0
"""Number of steps as which a misfit counts that is alike in a whole log. In simulated logs 97 % of the
errors of hard and soft iron are within two standard errors with it."""
SHAPE_COST: Final = 0.01**2
"""Squared misfit that an element of soft iron of 1 costs."""
MOUNTING_ERROR: Final = 0.01
"""Error of the axes of two sensors against each other, rad, which looks like a rotation by soft iron: boards and data
sheets allow half a degree."""
MAX_SHAPE_ERROR: Final = 0.02
"""Largest standard error of an element of soft iron with which it is told."""

# --- gravity and units -----------------------------------------------------------------------------------------------
GRAVITY: Final = 9.80665
"""Standard gravity, m/s²."""
ACCELEROMETER_UNITS: Final = {"m/s²": GRAVITY, "g": 1.0, "mg": 1e3, "cm/s²": 100.0 * GRAVITY}
"""Gravity in the units of accelerometers."""
FIELD_T: Final = 3.8e-5
"""Size of the earth's field, T, within a factor of two."""
MAGNETOMETER_UNITS: Final = {
    "T": FIELD_T,
    "G": FIELD_T * 1e4,
    "µT": FIELD_T * 1e6,
    "mG": FIELD_T * 1e7,
    "nT": FIELD_T * 1e9,
}
"""This field in the units of magnetometers."""


def nearest_unit(size: float, units: Mapping[str, float]) -> tuple[float, str, float]:
    """Absolute logarithm of the ratio of a size to the one of a table that is most like it, its unit, and this one."""
    return min((abs(np.log(size / known)), unit, known) for unit, known in units.items())


SAME_FIELD: Final = 1.15
"""Logarithm of the ratio to it up to which a field is the earth's: 12 to 120 µT, as iron adds as much again."""
OTHER_FIELD: Final = 1.85
"""Logarithm of the ratio from which a unit explains the field, and a magnet near by does not."""
SAME_UNIT: Final = 0.07
"""Logarithm of the ratio to a unit's gravity up to which it is this unit: healthy recordings have 0.015 at most."""
OTHER_UNIT: Final = 0.15
"""Logarithm of the ratio to every unit's gravity from which it is an unknown unit."""
MAX_UNIT_MISFIT: Final = 0.1
"""Misfit over the size of gravity up to which an unknown unit is named."""
MAX_UNIT_LOG_ERROR: Final = 0.35
"""Largest SIGMAS standard errors of the logarithm of the gyro's factor with which one is: half an octave."""
MAX_SWING: Final = 0.35
"""Change of the mean specific force between windows, over its size, up to which it is gravity: healthy ones have 0.20
at most, those without gravity 0.6 and more."""
SWING_LENGTH_S: Final = 2.0
"""Length of the windows in which it changes, s."""
MIN_TAKEN_OFF: Final = 0.15
"""Offset over gravity from which a constant was taken off: means that were had 0.24 and more, healthy recordings have
0.026 at most."""
MAX_NO_GRAVITY: Final = 0.25
"""Mean specific force over gravity up to which gravity was removed: such recordings have 0.08 at most."""

# --- stamps and readings, without a model ----------------------------------------------------------------------------
MAX_REPEATED_STAMPS: Final = 0.01
"""Share of repeated stamps from which they are a mistake."""
BURST_STEP: Final = 0.2
"""Step, in mean steps, below which a reading follows in a burst."""
RATE_PARTS: Final = 20
"""Even stamps have the median step over two of so many parts of a log: few of these have a clock that was set."""
PAUSES: Final = 0.001
"""Share of the steps that this mean leaves out, the longest: a log that paused has no bursts."""
MAX_IN_BURSTS: Final = 0.3
"""Share of such steps from which stamps come in bursts."""
GAP_STEP: Final = 5.0
"""Step, in median steps, above which there is a gap."""
MIN_HELD: Final = 0.25
"""Share of readings like the one before, while the sensor moves, from which a slower sensor is on these stamps."""
MIN_HOLD: Final = 1.8
"""Number of stamps over which a reading is held on average, from which this is a mistake."""
HELD_REACH: Final = 10
"""Number of readings over which the sensor moves or not."""
STUCK_SHARE: Final = 1e-6
"""Range of an axis, over that of the sensor, up to which the axis is stuck."""
CLIPPED_READINGS: Final = 3
"""Number of equal extremes in succession that are a range reached; there must be two such stretches."""
CLIPPED_DROP: Final = 1e-3
"""Drop beside them, over the range of the readings; no less than as many steps of the resolution as readings above."""
ROUND_OFF: Final = 1e-9
"""Drop up to which it is round-off, in any unit: 1 nT, or 1e-10 of gravity."""
MAX_CLIPPED: Final = 0.01
"""Share of a gyro's readings at its range from which it integrates no world: spinning phones had wrong names above."""
GYRO_HZ: Final = 90.0
"""Rate from which readings of the gyro are averaged in pairs and more, Hz."""
VECTOR_HZ: Final = 45.0
"""The rate for the other sensors, Hz."""
MAX_GRID_STEPS: Final = 2**24
"""Largest number of steps between the extremes of readings that are multiples of a resolution: sensors have 24 bits."""
GRID_TOLERANCE: Final = 0.01
"""Largest distance of such a reading from a multiple, in steps."""

# --- noise at rest ---------------------------------------------------------------------------------------------------
REST_WINDOW_S: Final = 1.0
"""Length of the windows that are at rest or not, s."""
MIN_REST_S: Final = 10.0
"""Least duration of rest that tells noise, s."""
MAX_REST_RATE: Final = np.radians(5.0)
"""Largest mean reading of a gyro at rest, rad/s: its bias."""
REST_SIGMAS: Final = 6.0
"""Largest change of the mean from window to window at rest, in standard errors of white noise."""
REST_PARTS: Final = 10
"""Number of parts of a window, whose means scatter as those of white noise at rest."""
MAX_REST_COLOUR: Final = 5.0
"""Largest ratio of the variance of these means to that of white noise: sensors have low-pass filters."""
MAX_VARIANCE_RATIO: Final = 4.0
"""Ratio of a declared variance and the scatter at rest from which they contradict each other."""

# --- against a truth -------------------------------------------------------------------------------------------------
MAX_TRUTH_MISFIT: Final = 0.5
"""Misfit of their rotations, as a share, above which a truth is not that of the gyro."""
MIN_TRUTH_MOUNTING: Final = np.radians(2.0)
"""Least angle between the axes of the gyro and of the truth's body that is a mistake, rad."""
