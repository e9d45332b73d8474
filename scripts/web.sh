#!/usr/bin/env bash
# Builds the web page into target/web: static files, for any server.
#   scripts/web.sh            builds
#   scripts/web.sh --serve    builds, and serves it at http://localhost:8000
set -euo pipefail
cd "$(dirname "$0")/.."

page=target/web
command -v rustup >/dev/null && rustup --quiet target add wasm32-unknown-unknown
# The sections that a strip would remove say which features of WebAssembly are in use.
CARGO_PROFILE_RELEASE_STRIP=debuginfo cargo build --release --target wasm32-unknown-unknown -p pathmarch-web
rm -rf "$page"
mkdir -p "$page"
# The libraries of `bindgen` add features to others, so that some are built that the tests have built without them.
cargo build --quiet --release --workspace --features pathmarch-web/bindgen --example bindgen --example export
target/release/examples/bindgen target/wasm32-unknown-unknown/release/pathmarch_web.wasm "$page"
target/release/examples/export "$page/scenes"
cp crates/pathmarch-web/page/* "$page"

size=$(cd "$page" && cat ./*.wasm ./*.js ./*.html ./*.css | gzip -9 | wc -c)
echo "$page: $((size / 1024)) KiB compressed, without the gallery"
if [ "${1-}" = --serve ]; then
    echo "http://localhost:8000"
    python3 -m http.server --directory "$page" 8000
fi
