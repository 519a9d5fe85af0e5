#!/bin/sh
# Print the path of a Python that this project can build an environment from.
#
#   find-python.sh live      Python 3.12 to 3.14 on Linux x86-64, which wheels of the ROS 2 client library are built for
#   find-python.sh jazzy     Python 3.12 there, for rclpy 7.1 of ROS 2 Jazzy
#   find-python.sh kilted    Python 3.13 or 3.14 there, for rclpy 9.1 of ROS 2 Kilted
#   find-python.sh headless  Python 3.10 or newer
#   find-python.sh bench     Python 3.10 or 3.11 on Linux x86-64, which PyBullet is built for
#
# PYTHON=... names the one to use; PYTHON_ROS=... the one for ROS ("none": pretend there is none).
# Exit status 3 when there is none. Each candidate is really run: a shim on PATH may exist and yet fail, and Debian's
# python3 comes without venv.
set -u

kind=$1
case $kind in
    live) chosen=${PYTHON_ROS:-${PYTHON:-}} ; names="python3.12 python3 python3.14 python3.13 python" ;;
    jazzy) chosen=${PYTHON_ROS:-${PYTHON:-}} ; names="python3.12 python3 python" ;;
    kilted) chosen=${PYTHON_ROS:-${PYTHON:-}} ; names="python3.14 python3.13 python3 python" ;;
    headless) chosen=${PYTHON:-} ; names="python3 python3.12 python3.13 python3.14 python3.11 python3.10 python" ;;
    bench) chosen=${PYTHON:-} ; names="python3.11 python3.10 python3 python" ;;
    *) echo "find-python.sh: '$kind' is none of live, jazzy, kilted, headless, bench" >&2; exit 2 ;;
esac

probe='
import os, platform, sys
kind = sys.argv[1]
# The one below an activated environment, which may be the very one that is made anew.
python = os.path.realpath(getattr(sys, "_base_executable", None) or sys.executable)
fits = sys.version_info >= (3, 10) and sys.implementation.name == "cpython"
ros = {"live": (12, 13, 14), "jazzy": (12,), "kilted": (13, 14)}
if kind in ros:
    libc, version = platform.libc_ver()
    fits = (
        fits
        and sys.version_info[1] in ros[kind]
        and (sys.platform, platform.machine(), libc) == ("linux", "x86_64", "glibc")
        and tuple(map(int, version.split(".")[:2])) >= (2, 28)
    )
if kind == "bench":
    built_for = (sys.platform, platform.machine()) == ("linux", "x86_64")
    fits = fits and built_for and sys.version_info < (3, 12)
if not fits:
    sys.exit(1)
try:
    import ensurepip, venv
except ImportError:
    print(python)
    sys.exit(4)
print(python)
'
without_venv=

# Prints the interpreter and succeeds when the candidate fits.
fits() {
    [ -x "$1" ] || return 1
    found=$("$1" -I -B -c "$probe" "$kind" 2>/dev/null </dev/null)
    status=$?
    [ $status -eq 4 ] && without_venv=$found
    [ $status -eq 0 ] && printf '%s\n' "$found"
}

missing() {
    if [ -n "$without_venv" ]; then
        echo "make: $without_venv has no venv module; on Debian and Ubuntu: apt install python3-venv" >&2
    fi
    exit 3
}

if [ "$chosen" = none ]; then
    exit 3
elif [ -n "$chosen" ]; then
    fits "$(command -v "$chosen")" && exit 0
    missing
fi

old_ifs=$IFS
for name in $names; do
    IFS=:
    for folder in $PATH /usr/local/bin /usr/bin /opt/homebrew/bin; do
        IFS=$old_ifs
        fits "$folder/$name" && exit 0
    done
    IFS=$old_ifs
done

# Where version managers keep the interpreters that are not on PATH.
for name in $names; do
    for candidate in \
        "${PYENV_ROOT:-$HOME/.pyenv}"/versions/*/bin/"$name" \
        "${UV_PYTHON_INSTALL_DIR:-${XDG_DATA_HOME:-$HOME/.local/share}/uv/python}"/*/bin/"$name" \
        "$HOME"/.local/share/mise/installs/python/*/bin/"$name" \
        "$HOME"/.asdf/installs/python/*/bin/"$name" \
        "$HOME"/*conda*/bin/"$name" "$HOME"/*conda*/envs/*/bin/"$name" \
        "$HOME"/miniforge*/bin/"$name" "$HOME"/miniforge*/envs/*/bin/"$name" \
        /opt/*conda*/bin/"$name" /opt/*conda*/envs/*/bin/"$name" \
        /opt/python/*/bin/"$name"
    do
        fits "$candidate" && exit 0
    done
done
missing
