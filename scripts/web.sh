#!/usr/bin/env bash
# Builds the web page into target/web: static files, for any server.
#   scripts/web.sh            builds
#   scripts/web.sh --serve    builds, and serves it at http://localhost:8000
set -euo pipefail
cd "$(dirname "$0")/.."

page=target/web
bindgen=$(sed -n 's/^wasm-bindgen = "=\(.*\)"$/\1/p' Cargo.toml)
export PATH="$PWD/target/tools/bin:$PATH"
rustup target add wasm32-unknown-unknown 2>/dev/null || true
[ "$(wasm-bindgen --version 2>/dev/null)" = "wasm-bindgen $bindgen" ] ||
    cargo install --quiet --locked --root target/tools --version "$bindgen" wasm-bindgen-cli

rm -rf "$page"
mkdir -p "$page"
wasm-bindgen --target web --no-typescript --out-dir "$page" target/wasm32-unknown-unknown/release/pathmarch_web.wasm
cp crates/pathmarch-web/page/* "$page"

cargo run --quiet --release -p pathmarch-gallery --example export "$page/scenes"

size=$(cd "$page" && cat ./*.wasm ./*.js ./*.html ./*.css | gzip -9 | wc -c)
echo "$page: $((size / 1024)) KiB compressed, without the gallery"
if [ "${1-}" = --serve ]; then
    echo "http://localhost:8000"
    python3 -m http.server --directory "$page" 8000
fi
