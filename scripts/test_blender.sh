#!/usr/bin/env bash
# Tests the add-on of Blender (editors/blender) in a Blender without a window; installs that of Debian where there is none.
#   scripts/test_blender.sh              in `blender`
#   scripts/test_blender.sh PYTHON       in an interpreter that has the module bpy of PyPI
set -euo pipefail
cd "$(dirname "$0")/.."

if [ $# = 0 ] && ! command -v blender >/dev/null; then
    sudo=""
    [ "$(id -u)" = 0 ] || sudo=sudo
    $sudo apt-get update -qq
    $sudo apt-get install -y -qq --no-install-recommends blender >/dev/null
fi

# In CI the tests have built it, with features that differ.
[ -n "${CI-}" ] && [ -x target/release/pathmarch ] || cargo build --quiet --release -p pathmarch
program=$PWD/target/release/pathmarch
test=editors/blender/test_pathmarch_blender.py
if [ $# = 0 ]; then
    blender --background --factory-startup --python-exit-code 1 --python "$test" -- "$program"
else
    "$1" "$test" -- "$program"
fi
