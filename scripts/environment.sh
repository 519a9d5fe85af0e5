#!/bin/sh
# Bring one virtual environment inside the clone up to date, and print its folder on standard output.
#
#   environment.sh live      .venv           newest libraries and the ROS 2 client library: what the node needs
#   environment.sh headless  .venv-headless  the same without ROS
#   environment.sh tests     the first of these two that there is a Python for, and beside it what the tests need
#   environment.sh oldest    .venv-oldest    the libraries of Ubuntu 24.04, with ROS
#   environment.sh kilted    .venv-kilted    the client library of ROS 2 Kilted, on a Python that Jazzy's has no wheel for
#   environment.sh docs      .venv-docs      what builds the site
#   environment.sh bench     .venv-bench     the software that the benchmark compares with, where it is built
#   environment.sh league    .venv-league    the attitude filters of other libraries
#
# Exit status 3 when there is no Python for `live`, `oldest` or `kilted`. The file `complete` is written last and removed first,
# so a set-up that was interrupted is thrown away and made anew by the next one.
set -eu
cd "$(dirname "$0")/.."
root=$PWD

no_python() {
    echo "make: no Python 3.10 or newer with venv found: install one, or name one with PYTHON=/path/to/python3" >&2
    exit 1
}

install() {
    $folder/bin/python -m pip install ${constraints:+--constraint $constraints} \
        ${never_compiled:+--only-binary $never_compiled} --editable ".[$extras]"
}

kind=$1
constraints= never_compiled=
case $kind in
    live | headless | tests)
        if [ $kind != headless ] && python=$(scripts/find-python.sh live); then
            folder=.venv extras=ros,fast
        elif [ $kind = live ]; then
            exit 3
        else
            python=$(scripts/find-python.sh headless) || no_python
            folder=.venv-headless extras=fast
        fi
        [ $kind != tests ] || extras=$extras,test,lint ;;
    oldest)
        python=$(scripts/find-python.sh jazzy) || exit 3
        folder=.venv-oldest extras=ros,test constraints=scripts/constraints-oldest.txt ;;
    kilted)
        python=$(scripts/find-python.sh kilted) || exit 3
        folder=.venv-kilted extras=ros,test ;;
    docs)
        python=$(scripts/find-python.sh headless) || no_python
        folder=.venv-docs extras=docs ;;
    bench)
        python=$(scripts/find-python.sh bench 2>/dev/null || scripts/find-python.sh headless) || no_python
        folder=.venv-bench extras=bench never_compiled=dartpy,drake,pybullet ;;
    league)
        python=$(scripts/find-python.sh live 2>/dev/null || scripts/find-python.sh headless) || no_python
        folder=.venv-league extras=fast,league ;;
    *)
        echo "environment.sh: unknown environment '$kind'" >&2
        exit 2 ;;
esac

base="$root $python"
wanted="$base $(cat setup.py setup.cfg pyproject.toml scripts/environment.sh $constraints | cksum) $extras"
leave_if_made() {
    made=
    if [ -f $folder/complete ] && $folder/bin/python -I -c '' 2>/dev/null; then
        made=$(cat $folder/complete)
        # With more extras than are wanted it will do: the node's come first.
        case $made in "$wanted"*) echo "$root/$folder"; exit 0 ;; esac
    fi
}
leave_if_made

# Two at a time would build the same metadata folder.
mkdir -p .cache
if command -v flock >/dev/null; then
    exec 9>.cache/environment.lock
    flock -n 9 || {
        echo "Waiting for another make, which sets up an environment" >&2
        flock 9
    }
fi

leave_if_made

echo "Setting up $folder with $python (once; it takes about a minute, as pip tells below)" >&2
# Not made to its end, elsewhere, or with another Python: its programs name the wrong interpreter.
[ "${made#"$base "}" != "$made" ] || rm -rf $folder
rm -f $folder/complete
[ -d $folder ] || "$python" -m venv $folder >&2
# What pip fetches and builds is told line by line; of what is there already it would tell hundreds of lines.
status=$({
    { install 3>&- && echo 0 >&3 || echo $? >&3; } | while IFS= read -r line; do
        case $line in "Requirement already satisfied"*) ;; *) printf '%s\n' "$line" >&2 ;; esac
    done
} 3>&1)
[ "$status" = 0 ] || exit "${status:-1}"
echo "$wanted" >$folder/complete
echo "$root/$folder"
