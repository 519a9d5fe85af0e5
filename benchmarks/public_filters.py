"""What ``diagnose`` says of public filters, compiled from checkouts of their repositories.

    python benchmarks/public_filters.py --checkouts FOLDER

FOLDER has a checkout of each repository, in a folder named OWNER+NAME; those that are not there are left out:

    git clone https://github.com/kriswiner/MPU9250 FOLDER/kriswiner+MPU9250

``shims/`` has a function in C++ for each library, which gives it readings one by one, and ``g++`` compiles it with the
sources of the checkout into a temporary folder. Each filter is given the units of its documentation. Its attitude is
turned from the world that it documents, with magnetic north, to east, north, up. So what is said is about the filter
itself, or of a sketch or an example about how it uses the filter.

``--filters NAME...`` chooses filters whose names contain one of them. What was found is in
``docs/explanation/what_it_found.md``.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial.transform import Rotation

from lie_rigid_body import diagnose
from lie_rigid_body.foundation.errors import LieRigidBodyError

Array = np.ndarray[Any, Any]

SHIMS: Final = Path(__file__).parent / "shims"
BUILT: Final = "PUBLIC_FILTERS_BUILT"
"""Environment variable with the folder of the compiled libraries, for the processes that run a filter."""
G: Final = 9.80665
RATE: Final = 100.0
"""Readings a second, which the boards are told by `begin`."""
NWU: Final = Rotation.from_rotvec([0.0, 0.0, np.pi / 2.0])
"""Rotation from north, west, up to east, north, up."""
ENU: Final = Rotation.identity()


@dataclass(frozen=True)
class Library:
    """A repository that has filters.

    Attributes
    ----------
    repository : str
        OWNER/NAME on GitHub.
    shim : str
        File in ``shims/``, without its suffix; also the name of the compiled library.
    include : str
        Folder of the checkout that has the headers, and the sources that the shim includes.
    sources : tuple of str
        Further sources, as patterns in the checkout.
    """

    repository: str
    shim: str
    include: str
    sources: tuple[str, ...] = ()

    def checkout(self, checkouts: Path) -> Path:
        """Folder of the checkout."""
        return checkouts / self.repository.replace("/", "+")

    def version(self, checkouts: Path) -> str:
        """Commit of the checkout, or nothing where it has no history."""
        folder = self.checkout(checkouts)
        told = subprocess.run(
            ["git", "-C", folder, "rev-parse", "--show-toplevel", "HEAD"], capture_output=True, text=True
        )
        top, _, commit = told.stdout.partition("\n")
        return f"at {commit[:7]}" if top and Path(top).samefile(folder) else "at an unknown commit"

    def compile(self, checkouts: Path, built: Path) -> None:
        """Compile the shim with the sources of the checkout."""
        folder = self.checkout(checkouts)
        flags = ["-O2", "-w", "-fPIC", "-fno-strict-aliasing", f"-I{SHIMS}", f"-I{folder / self.include}"]
        flags += [f"-I{path}" for path in sorted(folder.glob("*/include"))]
        objects = []
        for number, source in enumerate(
            [SHIMS / f"{self.shim}.cpp", *(s for p in self.sources for s in folder.glob(p))]
        ):
            compiler = "gcc" if source.suffix == ".c" else "g++"
            objects.append(built / f"{self.shim}{number}.o")
            subprocess.run([compiler, *flags, "-c", source, "-o", objects[-1]], check=True)
        subprocess.run(["g++", "-shared", *objects, "-o", built / f"{self.shim}.so"], check=True)


IMU_TOOLS: Final = Library(
    "CCNYRoboticsLab/imu_tools",
    "imu_tools",
    ".",
    ("imu_filter_madgwick/src/imu_filter.cpp", "imu_complementary_filter/src/complementary_filter.cpp"),
)
MPU9250: Final = Library("kriswiner/MPU9250", "mpu9250", ".")
SENSOR_FUSION: Final = Library("aster94/SensorFusion", "sensor_fusion", "src")
ADAFRUIT: Final = Library("adafruit/Adafruit_AHRS", "adafruit", "src", ("src/Adafruit_AHRS_NXPmatrix.c",))
ARDUINO: Final = Library("arduino-libraries/MadgwickAHRS", "madgwick_arduino", "src")
FUSION: Final = Library("xioTechnologies/Fusion", "fusion", "Fusion", ("Fusion/*.c",))


@dataclass(frozen=True)
class Public:
    """A filter, a function of a run.

    Attributes
    ----------
    library : Library
    function : str
        Name in the shim.
    settings : callable
        Settings that the shim is given, from the readings, rows of the gyro, the accelerometer and the magnetometer.
    gyro, accelerometer, magnetometer : float
        Units of the filter's readings in rad/s, m/s² and T: the factors that readings are multiplied by.
    axes : tuple of float
        Signs of the magnetometer's axes, as the code that calls the filter gives them.
    world : Rotation
        Rotation from the filter's world to east, north, up, but for the declination.
    """

    library: Library
    function: str
    settings: Callable[[Array, Array, Array], list[float]]
    gyro: float = 1.0
    accelerometer: float = 1.0
    magnetometer: float = 1e6
    axes: tuple[float, float, float] = (1.0, 1.0, 1.0)
    world: Rotation = NWU

    def __call__(self, run: Any) -> Array:
        """Attitudes, x y z w, world-from-body."""
        at = np.clip(np.searchsorted(run.magnetometer.t_ns, run.imu.t_ns, "right") - 1, 0, None)
        seconds = (run.imu.t_ns - run.imu.t_ns[0]) / 1e9
        gyro = self.gyro * run.imu.gyro
        accelerometer = self.accelerometer * run.imu.specific_force
        magnetometer = self.magnetometer * np.array(self.axes) * run.magnetometer.field[at]
        readings = np.column_stack([seconds, gyro, accelerometer, magnetometer])
        settings = np.array(self.settings(gyro, accelerometer, magnetometer))
        attitudes = np.empty((len(readings), 4))
        function = loaded(self.library.shim)[self.function]
        function(
            ctypes.c_long(len(readings)), *(x.ctypes.data_as(ctypes.c_void_p) for x in (readings, attitudes, settings))
        )
        east, north, _ = run.scenario.parameters()["magnetic_field"]
        declination = Rotation.from_rotvec([0.0, 0.0, -np.arctan2(east, north)])
        return product((declination * self.world).as_quat(), attitudes)


def product(p: Array, q: Array) -> Array:
    """Product of a quaternion with each row; a row that is not finite stays so."""
    x, y, z, w = p
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    return np.asarray(q @ left.T)


@lru_cache
def loaded(shim: str) -> ctypes.CDLL:
    """The compiled library."""
    return ctypes.CDLL(str(Path(os.environ[BUILT]) / f"{shim}.so"))


def settings(*values: float) -> Callable[[Array, Array, Array], list[float]]:
    """Settings that are the same for all readings."""
    return lambda gyro, accelerometer, magnetometer: list(values)


def first_attitude(gyro: Array, accelerometer: Array, magnetometer: Array) -> list[float]:
    """Attitude of the first readings in the world east, north, up, by magnetic north."""
    up = accelerometer[0] / np.linalg.norm(accelerometer[0])
    east = np.cross(magnetometer[0], up)
    east /= np.linalg.norm(east)
    found: list[float] = Rotation.from_matrix([east, np.cross(up, east), up]).as_quat().tolist()
    return found


degrees = 180.0 / np.pi
imu_tools_madgwick = Public(IMU_TOOLS, "madgwick", first_attitude, magnetometer=1.0, world=ENU)
imu_tools_complementary = Public(IMU_TOOLS, "complementary", settings(1.0), magnetometer=1.0)
imu_tools_complementary_no_bias = Public(IMU_TOOLS, "complementary", settings(0.0), magnetometer=1.0)
mpu9250_madgwick = Public(MPU9250, "mpu9250", settings(1.0), accelerometer=1.0 / G)
mpu9250_mahony = Public(MPU9250, "mpu9250", settings(0.0), accelerometer=1.0 / G)
mpu9250_sketch = Public(MPU9250, "mpu9250", settings(0.0), accelerometer=1.0 / G, axes=(1.0, 1.0, -1.0))
"""MPU9250BasicAHRS.ino gives my, mx, mz: of the chip, whose x is the board's y and whose z points down."""
sensor_fusion_madgwick = Public(SENSOR_FUSION, "sensor_fusion", settings(1.0, 0.0))
sensor_fusion_mahony = Public(SENSOR_FUSION, "sensor_fusion", settings(0.0, 0.0))
sensor_fusion_init_quat = Public(SENSOR_FUSION, "sensor_fusion", settings(0.0, 1.0))
adafruit_madgwick = Public(ADAFRUIT, "madgwick", settings(RATE), degrees, 1.0 / G)
adafruit_mahony = Public(ADAFRUIT, "mahony", settings(RATE), degrees, 1.0 / G)
adafruit_nxp = Public(ADAFRUIT, "nxp", settings(RATE), degrees, 1.0 / G)
adafruit_nxp_example = Public(ADAFRUIT, "nxp", settings(RATE), degrees)
"""examples/calibrated_orientation gives m/s²."""
arduino_madgwick = Public(ARDUINO, "madgwick", settings(RATE), degrees, 1.0 / G)
fusion = Public(FUSION, "fusion", settings(0.0), degrees, 1.0 / G)
fusion_advanced = Public(FUSION, "fusion", settings(1.0), degrees, 1.0 / G)

FILTERS: Final = {name: each for name, each in list(globals().items()) if isinstance(each, Public)}


def main() -> None:
    """Compile, diagnose, and print what is said."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checkouts", type=Path, required=True)
    parser.add_argument("--filters", nargs="+", default=[""])
    given = parser.parse_args()
    chosen = {name: each for name, each in FILTERS.items() if any(word in name for word in given.filters)}
    libraries = dict.fromkeys(each.library for each in chosen.values())
    there = [library for library in libraries if library.checkout(given.checkouts).is_dir()]
    for library in libraries:
        if library not in there:
            print(f"no checkout of {library.repository}: {library.checkout(given.checkouts)}", file=sys.stderr)
    os.environ["PYTHONPATH"] = os.pathsep.join([str(SHIMS.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    with tempfile.TemporaryDirectory() as folder:
        os.environ[BUILT] = folder
        for library in there:
            library.compile(given.checkouts, Path(folder))
        for name, each in chosen.items():
            if each.library in there:
                print(f"\n{name}: {each.library.repository} {each.library.version(given.checkouts)}")
                for sentence in said(name):
                    print(f"  {sentence}", flush=True)


def said(name: str) -> Iterator[str]:
    """Sentences about a filter: headline, notes and remarks."""
    try:
        found = diagnose(f"public_filters:{name}")
    except LieRigidBodyError as error:
        yield str(error)
        return
    yield from found.sentences
    yield from (f"note {note.code}: {note.message}" for note in found.notes)
    yield from found.remarks
    yield f"{found.filter_runs} runs, {found.updates} readings."


if __name__ == "__main__":
    main()
