"""Logs of anybody's sensors: bags, and tables in text files, folders and zips.

- `log`: the readings of a log, and what was taken for what;
- `bags`: topics of Imu and MagneticField;
- `sources`: text files, and those in folders and zips, read within bounds;
- `tables`: dialects of CSV, headers and rows;
- `headings`: the sensor, the axis and the unit that the header of a column names;
- `times`: columns of time in ns;
- `columns`: which columns of which tables are the sensors, and their readings.
"""

from lie_rigid_body.recording.logs.bags import Vectors
from lie_rigid_body.recording.logs.log import Log, read_log, require_overlap

__all__ = ["Log", "Vectors", "read_log", "require_overlap"]
