#!/usr/bin/env bash
# Builds the wheel that runs on every Linux system with this processor's architecture into target/packages: the module and the
# program for several instruction sets, linked with an old C library. `scripts/package.sh` must have run before.
set -euo pipefail
cd "$(dirname "$0")/.."

target=$(rustc -vV | sed -n 's/^host: //p')
glibc=2.28
sets=baseline
[[ $target != x86_64-* ]] || sets="baseline x86-64-v3"
tools=$PWD/target/tools
export PATH="$tools/bin:$PATH" PYTHONPATH="$tools${PYTHONPATH:+:$PYTHONPATH}"
python3 -c "import wheel" 2>/dev/null || python3 -m pip install --quiet --upgrade --target "$tools" wheel

for set in $sets; do
    flags=""
    [ "$set" = baseline ] || flags="-C target-cpu=$set"
    RUSTFLAGS=$flags cargo zigbuild --release --locked --lib -p pathmarch-python --target "$target.$glibc" \
        --target-dir "target/builds/$set"
done

# The wheel of this machine has everything else.
scripts/build_wheel.sh
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m wheel unpack --dest "$folder" target/wheels/pathmarch-*.whl
tree=$(echo "$folder"/pathmarch-*)
scripts=$(echo "$tree"/pathmarch-*.data/scripts)
module() { echo "target/builds/$1/$target/release/libpathmarch_python.so"; }
program() { echo "target/builds/$1/$target/release/pathmarch"; }
cp "$(module baseline)" "$tree/pathmarch/_native.abi3.so"
cp "$(program baseline)" "$scripts/pathmarch"
for set in ${sets#baseline}; do
    mkdir -p "$tree/pathmarch/_builds/$set"
    cp "$(module "$set")" "$tree/pathmarch/_builds/$set/_native.abi3.so"
    cp "$(program "$set")" "$scripts/pathmarch-$set"
done
python3 -m wheel pack --dest-dir "$folder" "$tree" >/dev/null
python3 -m wheel tags --remove --platform-tag "manylinux_${glibc/./_}_${target%%-*}" "$folder"/pathmarch-*.whl >/dev/null
cp "$folder"/pathmarch-*.whl target/packages/
ls -l target/packages/*.whl
