#!/usr/bin/env bash
# Builds the manual as a site of static files: target/book/html/index.html. Needs mdBook, Python and cargo; nothing is
# installed. With --no-api the documentation of the libraries is left out, which takes the most time.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/links.py
cargo run --quiet --release -p pathmarch-scene --example reference > target/words.md
[ "${1:-}" = --no-api ] || cargo doc --quiet --release --workspace --no-deps
scripts/book.py prepare
if ! command -v mdbook >/dev/null; then
    echo "The chapters are in target/book/src. To make a site of them, install mdBook: cargo install mdbook --locked," >&2
    echo "or a program from https://github.com/rust-lang/mdBook/releases; then run this again." >&2
    exit 1
fi
mdbook build book
[ "${1:-}" = --no-api ] || cp -r target/doc target/book/html/api
scripts/book.py check
