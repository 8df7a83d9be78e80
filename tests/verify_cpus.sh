#!/usr/bin/env bash
# One lock, every machine: the tiny paper from an empty store at each thread count, instruction set, build profile and
# emulated CPU that can be had here, each compared with artifacts/tiny.lock by `encounter verify --rebuild`.
#
# usage: tests/verify_cpus.sh [--all]     --all: a machine that has to be skipped is a failure (CI)
#
# Emulation needs qemu-user, the other architecture a compiler for it. As root on Debian what is missing is installed.
set -euo pipefail
cd "$(dirname "$0")/.."

must_have_all=false
[ "${1:-}" = --all ] && must_have_all=true
cargo=$(rustup which cargo 2>/dev/null || command -v cargo)
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT
failed=0 skipped=0 count=0

# row MACHINE LEVEL THREADS RESULT SECONDS
row() { printf '%-34s %-7s %7s  %-28s %8s\n' "$@"; }

skip() { # MACHINE WHY
    skipped=$((skipped + 1))
    row "$1" - - "skipped: $2" -
}

# verify MACHINE LEVEL THREADS COMMAND..: LEVEL `-` leaves the choice to the CPU.
verify() {
    local machine=$1 level=$2 threads=$3 log start seconds
    shift 3
    count=$((count + 1))
    log="$logs/$count"
    start=$(date +%s.%N)
    if [ "$level" != - ]; then export ENCOUNTER_LEVEL=$level; fi
    if "$@" verify --rebuild --profile tiny -j "$threads" >"$log" 2>&1; then
        result="$(tail -n 1 "$log" | sed 's/^.*: //; s/ made from nothing in [^,]*//')"
    else
        result="DIFFERS"
        failed=$((failed + 1))
    fi
    unset ENCOUNTER_LEVEL
    seconds=$(date +%s.%N | awk -v start="$start" '{ printf "%.1f", $1 - start }')
    row "$machine" "$level" "$threads" "$result" "$seconds"
    if [ "$result" = DIFFERS ]; then sed 's/^/    /' "$log"; fi
}

# install PACKAGE..: as root, where there is apt-get; false if it cannot be.
install() {
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return 1
    { apt-get update -q && apt-get install -qy --no-install-recommends "$@"; } >"$logs/apt" 2>&1
}

# The other architecture's standard library: rustup's, or Debian's compiler with it, unpacked beside the build.
aarch64_build() {
    local target=aarch64-unknown-linux-gnu root=$PWD/target-aarch64/debian
    command -v aarch64-linux-gnu-gcc >/dev/null || install gcc-aarch64-linux-gnu libc6-dev-arm64-cross || return 1
    export CARGO_TARGET_DIR=$PWD/target-aarch64 CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    export CARGO_INCREMENTAL=0 CARGO_PROFILE_RELEASE_DEBUG=false
    if ! rustup target add "$target" >/dev/null 2>&1; then
        if [ ! -x "$root/usr/bin/rustc" ]; then
            unpack_debian_rustc "$root" || return 1
        fi
        export LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu RUSTC=$root/usr/bin/rustc
    fi
    "$cargo" build --quiet --release --target "$target" --bin encounter
}

# Debian's compiler conflicts with its rustup package, so nothing is installed: the archives are unpacked.
unpack_debian_rustc() { # FOLDER
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return 1
    dpkg --add-architecture arm64 && apt-get update -q >/dev/null || return 1
    local std llvm archives=$logs/archives
    std=$(apt-cache depends rustc-web | awk '/Depends: libstd-rust-web-[0-9]/ { print $2; exit }')
    llvm=$(apt-cache depends "$std" | awk '/Depends: libllvm/ { print $2; exit }')
    mkdir -p "$archives" "$1"
    (cd "$archives" && apt-get download -q rustc-web "$std" "$llvm" libstd-rust-web-dev libstd-rust-web-dev:arm64) \
        >"$logs/download" 2>&1 || return 1
    for archive in "$archives"/*.deb; do dpkg-deb -x "$archive" "$1"; done
}

cargo build --quiet --release --bin encounter
cargo build --quiet --bin encounter
native=target/release/encounter
host="$(uname -m), $(rustc --version | cut -d' ' -f1,2)"

row machine level threads lock seconds
for threads in 1 2 7; do verify "$host" - "$threads" $native; done
for level in base avx2 avx512; do
    if why=$(ENCOUNTER_LEVEL=$level $native status --profile tiny 2>&1 >/dev/null); then
        verify "$host" "$level" 2 $native
    else
        skip "$host, $level" "${why##*: }"
    fi
done
verify "$host, debug build" - 2 target/debug/encounter

if [ "$(uname -m)" != x86_64 ]; then
    skip "Nehalem, Haswell, aarch64 emulated" "the host is no x86-64"
elif ! command -v qemu-x86_64 >/dev/null && ! install qemu-user; then
    skip "Nehalem, Haswell, aarch64 emulated" "qemu-user cannot be had"
else
    verify "Nehalem emulated" - 2 qemu-x86_64 -cpu Nehalem $native
    verify "Haswell emulated" - 2 qemu-x86_64 -cpu Haswell $native
    if (aarch64_build) >"$logs/aarch64" 2>&1; then
        verify "aarch64 emulated" - 2 qemu-aarch64 -L /usr/aarch64-linux-gnu \
            target-aarch64/aarch64-unknown-linux-gnu/release/encounter
    else
        skip "aarch64 emulated" "no compiler for it; $(tail -n 1 "$logs/aarch64")"
    fi
fi

echo "$((count - failed)) of $count equal, $skipped skipped"
[ "$failed" = 0 ] || exit 3
if $must_have_all && [ "$skipped" != 0 ]; then exit 1; fi
