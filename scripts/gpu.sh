#!/usr/bin/env bash
# Everything that is to be known of a GPU, in one run of under eight minutes (builds not counted):
# the adapter, the GPU tests, pictures of both backends against each other, benchmarks with the GPU's own clock,
# registers and occupancy where the driver reports them, cold start, live frames a second, memory, a lost device.
#
#   scripts/gpu.sh [--adapter NAME] [--out FOLDER]      builds what is missing with cargo, then measures
#   scripts/gpu.sh --pack FOLDER                        builds and copies the programs, for a machine without Rust
#   scripts/gpu.sh --programs FOLDER [...]              measures with programs packed before
#
# Each step writes FOLDER/NN-step.txt (default: gpu-report/); a failed step does not stop the others. The exit code is the
# number of failed steps. A packed run needs the repository at the same path there: the tests read their data by it.
set -uo pipefail
cd "$(dirname "$0")/.."

out=gpu-report programs="" pack="" adapter=()
while [ $# -gt 0 ]; do
    case "$1" in
        --out) out=${2:?--out needs a folder}; shift 2 ;;
        --programs) programs=${2:?--programs needs a folder}; shift 2 ;;
        --pack) pack=${2:?--pack needs a folder}; shift 2 ;;
        --adapter) adapter=(--adapter "${2:?--adapter needs a name}"); shift 2 ;;
        *) sed -n '2,14s/^# \{0,1\}//p' "$0"; exit 2 ;;
    esac
done

# Paths of the executables that a cargo command builds, one a line.
executables() { cargo "$@" --message-format=json 2>/dev/null | grep -o '"executable":"[^"]*"' | cut -d'"' -f4; }

# Builds the programs and the GPU tests into a folder.
build_into() {
    mkdir -p "$1/tests"
    cargo build --release -p pathmarch -p pathmarch-measure || return 1
    cp target/release/pathmarch target/release/pathmarch-measure "$1/"
    executables test --release -p pathmarch-render --test all --no-run | while read -r test; do cp "$test" "$1/tests/"; done
    executables bench -p pathmarch-render --bench live --no-run | while read -r bench; do cp "$bench" "$1/live"; done
    strip "$1"/pathmarch "$1"/pathmarch-measure "$1"/live "$1"/tests/* 2>/dev/null || true
}

if [ -n "$pack" ]; then
    build_into "$pack" && du -sh "$pack"
    exit
fi
if [ -z "$programs" ]; then
    programs=target/gpu-programs
    build_into "$programs" || exit 1
fi
pathmarch=$programs/pathmarch measure=$programs/pathmarch-measure
mkdir -p "$out"
failed=0 number=0 began=$SECONDS

# step NAME SECONDS COMMAND...: runs a command within a time, its output into a file.
step() {
    number=$((number + 1))
    local file started=$SECONDS
    file=$(printf '%s/%02d-%s.txt' "$out" "$number" "$1")
    local name=$1 limit=$2
    shift 2
    local run=("$@")
    # A function runs in a shell of its own, so that its time can be limited.
    if [ "$(type -t "$1")" = function ]; then
        run=(bash -c "$(declare -p pathmarch measure programs adapter); $(declare -f "$1"); $1")
    fi
    if timeout --kill-after=5 "$limit" "${run[@]}" >"$file" 2>&1; then
        echo "ok      $name ($((SECONDS - started)) s)"
    else
        echo "FAILED  $name (exit $?, $((SECONDS - started)) s): $(tail -n 1 "$file")"
        failed=$((failed + 1))
    fi
}

machine() {
    uname -srm
    lscpu 2>/dev/null | grep -E '^(Model name|CPU\(s\)|Thread)'
    nvidia-smi --query-gpu=name,driver_version,memory.total,clocks.max.sm --format=csv 2>/dev/null
    vulkaninfo --summary 2>/dev/null
    "$pathmarch" devices
}

# The tests that need an adapter; without one they fail here instead of being ignored.
tests() {
    local status=0 folder
    folder=$(mktemp -d)
    for test in "$programs"/tests/*; do
        PATHMARCH_REQUIRE_GPU=1 "$test" >"$folder/log" 2>&1 || status=1
        grep -E '^(test .*FAILED|test result|failures:)|panicked' "$folder/log"
    done
    rm -r "$folder"
    return $status
}

# Every scene on both backends with one seed; relMSE is that of rounding and of single paths that go another way.
pictures() {
    local folder status=0
    folder=$(mktemp -d)
    for scene in scenes/*.kdl scenes/thesis/*.kdl scenes/fractals/*.kdl; do
        for backend in cpu gpu; do
            local which=()
            [ $backend = gpu ] && which=("${adapter[@]}")
            "$pathmarch" render "$scene" --backend $backend "${which[@]}" --size 160x90 --samples 16 \
                -o "$folder/$backend.exr" >/dev/null 2>"$folder/log" || { cat "$folder/log"; status=1; continue 2; }
        done
        printf '%-40s %s\n' "$scene" \
            "$("$pathmarch" compare "$folder/gpu.exr" "$folder/cpu.exr" --max-relmse 0.02 | tr -s ' \n' ' ')"
        [ "${PIPESTATUS[0]}" = 0 ] || status=1
    done
    rm -r "$folder"
    return $status
}

# Drivers that report registers and spills do so on standard error, when asked by these variables.
registers() {
    local folder
    folder=$(mktemp -d)
    for scene in scenes/thesis/diffuse-sphere.kdl scenes/cornell.kdl scenes/fractals/mandelbulb.kdl; do
        echo "== $scene"
        RADV_DEBUG=shaderstats INTEL_DEBUG=cs AMD_DEBUG=stats MESA_SHADER_CACHE_DISABLE=1 \
            "$pathmarch" render "$scene" --backend gpu "${adapter[@]}" --size 64x36 --samples 1 -o "$folder/x.exr" 2>&1 |
            grep -iE 'sgpr|vgpr|registers|spill|occupancy|scratch|SIMD[0-9]+|instructions' | head -n 20 ||
            echo "this driver reports none"
    done
    rm -r "$folder"
    echo "NVIDIA's Vulkan driver reports none; Nsight Graphics shows registers and occupancy of a captured frame."
}

# From the start of the process to the file, nothing of shaders cached: five times.
cold_start() {
    local folder
    folder=$(mktemp -d)
    export __GL_SHADER_DISK_CACHE=0 MESA_SHADER_CACHE_DISABLE=1
    for scene in scenes/thesis/diffuse-sphere.kdl scenes/cornell.kdl scenes/fractals/mandelbulb.kdl; do
        for _ in 1 2 3 4 5; do
            local start end
            start=$(date +%s%N)
            "$pathmarch" render "$scene" --backend gpu "${adapter[@]}" --size 640x360 --samples 1 -o "$folder/x.exr" \
                2>/dev/null || return 1
            end=$(date +%s%N)
            echo "$scene $(((end - start) / 1000000)) ms"
        done
    done
    rm -r "$folder"
}

# Device memory while a 4K picture is rendered, where nvidia-smi or the kernel tell it.
memory() {
    local folder
    folder=$(mktemp -d)
    "$pathmarch" render scenes/cornell.kdl --backend gpu "${adapter[@]}" --size 3840x2160 --samples 1000000 \
        --seconds 6 -o "$folder/x.exr" 2>/dev/null &
    local render=$!
    sleep 4
    nvidia-smi --query-compute-apps=pid,used_memory --format=csv 2>/dev/null
    grep -hE 'drm-(memory|total)' /proc/$render/fdinfo/* 2>/dev/null | sort | uniq
    wait $render
    local status=$?
    rm -r "$folder"
    return $status
}

step machine 20 machine
step tests 150 tests
step pictures 90 pictures
step bench-thesis 45 "$measure" bench thesis --limit 3 --backend gpu "${adapter[@]}" --json "$out/bench-thesis.json"
step bench-quality 60 "$measure" bench quality --backend gpu "${adapter[@]}" --error 2 --limit 3 --json "$out/bench-quality.json"
step bench-default 60 "$measure" bench --limit 3 --backend gpu "${adapter[@]}" --json "$out/bench-default.json"
step registers 20 registers
step cold-start 40 cold_start
step live-720p 30 "$programs/live" --gpu-only --size 1280x720
step live-1080p 30 "$programs/live" --gpu-only --size 1920x1080
step memory 20 memory
echo "$number steps, $failed failed, $((SECONDS - began)) s; see $out/"
exit $failed
