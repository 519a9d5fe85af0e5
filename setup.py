"""All metadata of the package, for pip and for colcon alike.

It lives here and not in pyproject.toml because colcon silently skips a package with a ``[project]`` table there.
"""

import sys
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

NAME = "lie_rigid_body"

# colcon symlinks this file into its build folder, but not the README beside it.
README = Path(__file__).resolve().parent / "README.md"

# `ros2 run` looks for executables in lib/lie_rigid_body, where short names are safe; a virtual environment has one bin
# folder for everything, where `check` or `plot` would hide somebody else's program. colcon, bloom and Debian's tools
# call this file with `install` or `develop`; pip and other wheel builders with `bdist_wheel`, `editable_wheel` or
# `dist_info`. Those commands run `install` inside, so only the command line tells the two apart.
FOR_ROS = not {"install", "develop"}.isdisjoint(sys.argv[1:])
ONE_NAME = [f"lie-rigid-body = {NAME}.__main__:main"]
ROS_NAMES = [
    f"sim = {NAME}.ros.sim:main",
    f"record = {NAME}.cli.record:main",
    f"check = {NAME}.cli.check:main",
    f"recover = {NAME}.cli.recover:main",
    f"plot = {NAME}.cli.plot:main",
    f"evaluate = {NAME}.__main__:evaluate",
    f"explain = {NAME}.cli.explain:main",
    f"scenarios = {NAME}.cli.scenarios:main",
    f"campaign = {NAME}.cli.campaign:main",
    f"inspect = {NAME}.cli.inspect:main",
    f"diagnose = {NAME}.cli.diagnose:main",
    f"league = {NAME}.cli.league:main",
]

# Integers of NumPy 1 have 32 bits on Windows, where ROS and its keys of rosdep do not matter.
ON_WINDOWS = "; sys_platform == 'win32'"
# The lower bounds are what apt gives on Ubuntu 24.04 (ROS 2 Jazzy) wherever it has the library.
REQUIRES = [
    "lz4>=4.0",
    "mcap>=1.5",
    "matplotlib>=3.6.3",
    "numpy>=1.26",
    f"numpy>=2{ON_WINDOWS}",
    "PyYAML>=6.0.1",
    "scipy>=1.11",
    "tqdm>=4.66",
    "zstandard>=0.22",
]
# rclpy of Jazzy has wheels for Python 3.12, that of Kilted for 3.12 to 3.14.
JAZZY_HAS_WHEELS = "; python_version == '3.12' and sys_platform == 'linux'"
KILTED_HAS_WHEELS = "; python_version in '3.13 3.14' and sys_platform == 'linux'"
# Exact, so that a table of docs/benchmarks.md can be made again. Of Drake and DART these are the last wheels for Python
# 3.10 and 3.11, which PyBullet has wheels for; elsewhere it has to be compiled, which takes very long.
PYBULLET_WHEELS_EXIST = "; python_version < '3.12' and sys_platform == 'linux' and platform_machine == 'x86_64'"
SIMULATORS = [
    "mujoco==4.0.0; python_version >= '3.11'",
    "mujoco==3.17.0; python_version < '3.11'",
    f"drake==1.51.1{PYBULLET_WHEELS_EXIST}",
    f"dartpy==6.20.0{PYBULLET_WHEELS_EXIST}",
    f"pybullet==3.2.7{PYBULLET_WHEELS_EXIST}",
]
# Exact for the same reason. Orekit needs a Java of 11 or newer beside it.
SOLVERS = [
    "orekit-jpype==13.1.9.0",
    "jax==0.10.2; python_version >= '3.11'",
    "diffrax==0.7.2; python_version >= '3.11'",
    "jaxlie==1.5.0; python_version >= '3.11'",
]
PLOTLY = "plotly>=6"
PYARROW = "pyarrow>=15"
DISTRIBUTED = "distributed>=2024.5"
PYTHON_FLINT = "python-flint>=0.9"
# For glibc and CPython 3.10 to 3.14 so far; elsewhere FLINT has to be there already.
FLINT_WHEELS_EXIST = (
    "; platform_python_implementation == 'CPython' and python_version < '3.15' and "
    "(sys_platform != 'linux' or platform_machine in 'x86_64 aarch64')"
)
EXTRAS = {
    "bench": [PYARROW, *SIMULATORS, *SOLVERS, "numba"],
    # make league: every attitude filter of PyPI that takes gyro, accelerometer and magnetometer
    "league": ["ahrs", "filterpy", "gtsam", "imufusion", "qmt", "scikit-kinematics", "vqf"],
    "ros": [
        f"ros-rclpy[fastrtps]==7.1.6{JAZZY_HAS_WHEELS}",
        f"ros-common-interfaces==5.3.6{JAZZY_HAS_WHEELS}",
        f"ros-rclpy[fastrtps]==9.1.2{KILTED_HAS_WHEELS}",
        f"ros-common-interfaces==5.5.1{KILTED_HAS_WHEELS}",
    ],
    # Long integrations run compiled, to the same bits. It comes after each release of Python and NumPy with some delay.
    "fast": ["numba>=0.58"],
    # check --prove: the true motion in balls that are proved to hold it
    "proof": [PYTHON_FLINT],
    # many runs on all cores, and their table
    "campaign": [PYARROW],
    # campaign --scheduler: on the workers of a Dask cluster
    "cluster": [DISTRIBUTED, PYARROW],
    # check BAG --report: a page with a body that can be turned and played
    "report": [PLOTLY],
    "test": [
        DISTRIBUTED,
        PYARROW,
        "ahrs",
        "allantools",
        "build",
        "colcon-core",
        "colcon-ros",
        "evo",
        "hypothesis",
        "mcap-ros2-support",
        "mpmath",
        PLOTLY,
        "pytest>=7.4",
        "pytest-xdist",
        f"{PYTHON_FLINT}{FLINT_WHEELS_EXIST}",
        "rosbags",
        "setuptools",
        "twine",
        "wheel",
    ],
    # The last brings MathJax, so that pages need no network.
    "docs": ["furo", "myst-parser>=4", "sphinx>=8", "sphinx-mathjax-offline"],
    # Exact, so that a new release breaks nobody's tests. Types are checked with Python 3.12, which scipy-stubs needs.
    "lint": [
        "mypy==2.4.1",
        "ruff==0.17.6",
        "scipy-stubs==1.18.1.1; python_version >= '3.12'",
        "types-PyYAML==6.0.12.20261113",
        "types-tqdm==4.70.0.20261106",
    ],
}

# Folders of their own: what lies in config/ itself is a scenario.
VIEWS_AND_POLICIES = ["conformance", "foxglove", "league", "plotjuggler", "rosbag2", "rviz", "sros2"]

setup(
    name=NAME,
    version="1.0.0",
    description="Torque-free rigid-body motion on SO(3): a live ROS 2 node, bags, and a certificate of their accuracy",
    long_description=README.read_text(encoding="utf-8") if README.is_file() else "",
    long_description_content_type="text/markdown",
    author="Seed 2b615e39 maintainers",
    author_email="maintainers@users.noreply.h-seed-2b615e39.example",
    maintainer="Seed 2b615e39 maintainers",
    maintainer_email="maintainers@users.noreply.h-seed-2b615e39.example",
    license="Apache-2.0",
    keywords=["ROS 2", "rigid body", "Lie group", "SO(3)", "geometric integration", "MCAP"],
    classifiers=[
        "Intended Audience :: Science/Research",
        "Operating System :: MacOS",
        "Operating System :: Microsoft :: Windows",
        "Operating System :: POSIX :: Linux",
        "Programming Language :: Python :: 3",
        "Topic :: Scientific/Engineering :: Physics",
        "Typing :: Typed",
    ],
    python_requires=">=3.10",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    # lie_rigid_body/config is a link to config/: one set of files, found beside the code however it was installed.
    package_data={NAME: ["py.typed", "config/*.yaml", *(f"config/{folder}/*" for folder in VIEWS_AND_POLICIES)]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", sorted(glob("config/*.*"))),
        *((f"share/{NAME}/config/{folder}", sorted(glob(f"config/{folder}/*"))) for folder in VIEWS_AND_POLICIES),
        (f"share/{NAME}/launch", sorted(glob("launch/*.launch.py"))),
    ],
    install_requires=REQUIRES,
    extras_require=EXTRAS,
    entry_points={
        "console_scripts": ONE_NAME + (ROS_NAMES if FOR_ROS else []),
        "pytest11": [f"{NAME}.testing = {NAME}.testing"],
    },
    zip_safe=False,
)
