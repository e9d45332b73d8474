#!/usr/bin/env bash
# Tests the web page that scripts/web.sh has built in a headless Chromium; installs what that needs.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v chromedriver >/dev/null || ! command -v chromium >/dev/null; then
    sudo=""
    [ "$(id -u)" = 0 ] || sudo=sudo
    $sudo apt-get update -qq
    $sudo apt-get install -y -qq --no-install-recommends chromium chromium-driver >/dev/null
fi
export PYTHONPATH="$PWD/target/tools/selenium"
python3 -c "import selenium" 2>/dev/null ||
    python3 -m pip install --quiet --target target/tools/selenium selenium==4.51.0

# In CI the tests have built it, with features that differ.
[ -n "${CI-}" ] && [ -x target/release/pathmarch ] || cargo build --quiet --release -p pathmarch
scripts/test_web.py
