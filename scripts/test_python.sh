#!/usr/bin/env bash
# Builds the wheel of the Python package, installs it in an empty environment, and renders a picture with it. Prints the
# time from `pip install` to the picture, and sizes. Then runs the tests: of the package, its examples and the notebook.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD

scripts/build_wheel.sh
wheel=$(ls "$root"/target/wheels/pathmarch-*.whl)

environment=$root/target/python
rm -rf "$environment"
python3 -m venv "$environment"
bin=$environment/bin
[ -d "$bin" ] || bin=$environment/Scripts

# Away from the sources, so that the package is the installed one.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
started=$(date +%s%N)
"$bin/pip" install --quiet --disable-pip-version-check "$wheel"
installed=$(date +%s%N)
"$bin/python" - "$root/scenes/ten-lines.kdl" <<'PYTHON'
import sys, pathmarch
pathmarch.save("first.png", pathmarch.render(sys.argv[1], size=(640, 360), samples=16))
PYTHON
ended=$(date +%s%N)
megabytes() { stat -Lc %s "$1" | awk '{ printf "%.1f MB", $1 / 1e6 }'; }
seconds() { awk "BEGIN { printf \"%.1f s\", $1 / 1e9 }"; }
package=$("$bin/python" -c 'import os, pathmarch; print(os.path.dirname(pathmarch.__file__))')
echo "wheel: $(megabytes "$wheel"); module: $(megabytes "$package"/_native*); program: $(megabytes "$bin/pathmarch"*)"
echo "pip install: $(seconds $((installed - started))); first picture: $(seconds $((ended - installed)))"

"$bin/pip" install --quiet --disable-pip-version-check -r "$root/crates/pathmarch-python/tests/requirements.txt"
"$bin/python" -m pytest -q -p no:cacheprovider "$root/crates/pathmarch-python/tests"
