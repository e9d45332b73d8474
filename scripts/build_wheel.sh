#!/usr/bin/env bash
# Builds the wheel of the Python package into target/wheels, with the program `pathmarch` in it.
set -euo pipefail
cd "$(dirname "$0")/.."

export PATH="$PWD/target/maturin/bin:$PATH"
command -v maturin >/dev/null || python3 -m pip install --quiet --target target/maturin "maturin>=1.9.4,<2"

CARGO=$PWD/scripts/workspace_cargo.sh
"$CARGO" rustc >/dev/null
scripts=crates/pathmarch-python/wheel.data/scripts
mkdir -p "$scripts"
program=target/release/pathmarch
[ -e "$program" ] || program=$program.exe
cp "$program" "$scripts"
rm -f target/wheels/pathmarch-*.whl
CARGO=$CARGO maturin build --quiet --release --manifest-path crates/pathmarch-python/Cargo.toml
