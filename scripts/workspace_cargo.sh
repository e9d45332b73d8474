#!/usr/bin/env bash
# Cargo for maturin. `rustc`, by which maturin builds the library of the Python package, becomes a build with the
# features that the tests of the whole workspace have, and with the same variables, so that nothing is compiled twice.
set -euo pipefail
if [ "$1" != rustc ]; then
    exec cargo "$@"
fi
unset PYO3_CONFIG_FILE PYO3_ENVIRONMENT_SIGNATURE PYO3_PYTHON PYTHON_SYS_EXECUTABLE
# A test target turns on the features of development dependencies.
exec env -u CARGO cargo build --release --workspace --lib --bin pathmarch --test structure \
    --message-format json-render-diagnostics
