#!/usr/bin/env bash
# Builds packages of the program into target/packages: an archive, on Linux also a .deb, with checksums, the licences of all
# crates, and a bill of materials (CycloneDX). `scripts/package_wheel.sh` adds the Python package.
#   scripts/package.sh                            for this system
#   scripts/package.sh x86_64-pc-windows-gnu      for Windows, from Linux, with gcc-mingw-w64-x86-64
# The program is built for several instruction sets; the one in `bin` chooses when it starts.
set -euo pipefail
cd "$(dirname "$0")/.."

host=$(rustc -vV | sed -n 's/^host: //p')
target=${1-$host}
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
name=pathmarch-$version-$target
out=target/packages
tree=$out/$name
# The C library of Debian 10 and RHEL 8.
glibc=2.28
case $target in
    x86_64-*) sets="baseline x86-64-v3 x86-64-v4" ;;
    *) sets=baseline ;;
esac
suffix=
[[ $target != *windows* ]] || suffix=.exe

# Cargo; for Linux through zig, which links with an old C library.
build() {
    local set=$1
    local flags="" command=(build --target "$target")
    [ "$set" = baseline ] || flags="-C target-cpu=$set"
    [[ $target != *linux-gnu ]] || command=(zigbuild --target "$target.$glibc")
    RUSTFLAGS=$flags cargo "${command[@]}" --release --locked --bin pathmarch --target-dir "target/builds/$set"
}

if [[ $target == *linux-gnu ]]; then
    export PATH="$PWD/target/tools/bin:$PATH" PYTHONPATH="$PWD/target/tools${PYTHONPATH:+:$PYTHONPATH}"
    command -v cargo-zigbuild >/dev/null || python3 -m pip install --quiet --target target/tools cargo-zigbuild ziglang
fi
! command -v rustup >/dev/null || rustup --quiet target add "$target"

rm -rf "$tree"
mkdir -p "$tree/bin" "$tree/share/doc/pathmarch"
for set in $sets; do
    build "$set"
    built=target/builds/$set/$target/release/pathmarch$suffix
    case $set in
        baseline) cp "$built" "$tree/bin/" ;;
        *) mkdir -p "$tree/lib/pathmarch" && cp "$built" "$tree/lib/pathmarch/pathmarch-$set$suffix" ;;
    esac
done
cp README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "$tree/share/doc/pathmarch/"
scripts/notices.py "$target" >"$tree/share/doc/pathmarch/NOTICES.txt"
scripts/sbom.py "$target" >"$tree/share/doc/pathmarch/sbom.cdx.json"
cp "$tree/share/doc/pathmarch/sbom.cdx.json" "$out/$name.cdx.json"
install -D -m 644 editors/blender/pathmarch_blender.py "$tree/share/pathmarch/pathmarch_blender.py"

if [[ $target == *linux* ]]; then
    install -D -m 644 packaging/pathmarch.desktop "$tree/share/applications/pathmarch.desktop"
    install -D -m 644 packaging/icon.png "$tree/share/icons/hicolor/256x256/apps/pathmarch.png"
fi
# What the program prints about itself, where it can run.
if [ "$target" = "$host" ]; then
    program=$tree/bin/pathmarch$suffix
    mkdir -p "$tree/share/man/man1" "$tree/share/bash-completion/completions" "$tree/share/zsh/site-functions" \
        "$tree/share/fish/vendor_completions.d"
    "$program" man | gzip -9n >"$tree/share/man/man1/pathmarch.1.gz"
    "$program" completions bash >"$tree/share/bash-completion/completions/pathmarch"
    "$program" completions zsh >"$tree/share/zsh/site-functions/_pathmarch"
    "$program" completions fish >"$tree/share/fish/vendor_completions.d/pathmarch.fish"
fi

# Archive.
if [[ $target == *windows* ]]; then
    rm -f "$out/$name.zip"
    (cd "$out" && python3 -m zipfile -c "$name.zip" "$name")
else
    tar -C "$out" --numeric-owner -czf "$out/$name.tar.gz" "$name"
fi

# Debian package: the same tree under /usr.
if [[ $target == *linux-gnu ]] && command -v dpkg-deb >/dev/null; then
    case $target in
        aarch64-*) architecture=arm64 ;;
        *) architecture=amd64 ;;
    esac
    root=$out/deb-$architecture
    rm -rf "$root"
    mkdir -p "$root/DEBIAN" "$root/usr"
    cp -r "$tree"/* "$root/usr/"
    sed "s/@VERSION@/$version/; s/@ARCHITECTURE@/$architecture/; s/@SIZE@/$(du -sk "$root/usr" | cut -f1)/; s/@GLIBC@/$glibc/" \
        packaging/debian-control >"$root/DEBIAN/control"
    chmod -R u=rwX,go=rX "$root"
    dpkg-deb --root-owner-group -Zxz --build "$root" "$out/pathmarch_${version}_$architecture.deb" >/dev/null
    rm -rf "$root"
fi

checksum=sha256sum
command -v $checksum >/dev/null || checksum="shasum -a 256"
(cd "$out" && for file in *.tar.gz *.zip *.deb *.json; do [ ! -e "$file" ] || $checksum "$file"; done >SHA256SUMS)
ls -l "$out"
