# Sourced by `build`, `wheels` and `test` with the platforms of their arguments: the tools that build for other platforms, and
# how cargo is called for each.
#
# Needs Python 3.11 and Rust from rustup with the targets below. The packages from PyPI are in
# requirements.txt and stays below target/: maturin, and zig as a linker, with stubs of old versions of GLIBC and of Apple's
# system library.

case ${1:-} in -h | --help)
    sed -n '2,/^[^#]/s/^# \?//p' "packaging/$(basename "$0")"
    exit
    ;;
esac
for tool in cargo rustc python3; do
    command -v $tool >/dev/null || { echo "$0: $tool is missing" >&2 && exit 1; }
done

# GLIBC 2.17 of 2012 is what manylinux2014 asks for.
declare -A triples=(
    [linux64]=x86_64-unknown-linux-gnu
    [aarch64-linux]=aarch64-unknown-linux-gnu
    [win64]=x86_64-pc-windows-gnu
    [darwin64]="x86_64-apple-darwin aarch64-apple-darwin"
    [wasm]=wasm32-unknown-unknown
)
missing_triples() { # PLATFORM…: those without Rust's standard library.
    for platform in "$@"; do
        for triple in ${triples[$platform]}; do
            [ -d "$(rustc --print target-libdir --target "$triple")" ] || echo "$triple"
        done
    done
}
platforms=("$@")
[ $# -gt 0 ] || platforms=(linux64 aarch64-linux win64 darwin64 wasm)
for platform in "${platforms[@]}"; do
    if [ -z "${triples[$platform]:-}" ]; then
        echo "$0: \`$platform\` is not one of linux64, aarch64-linux, win64, darwin64, wasm" >&2
        exit 2
    fi
done

# Everything at its fastest, unless it is built for a test alone; the libraries have the same bytes in both profiles.
profile=${CAMDRIVE_PROFILE:-dist}
root=$PWD
venv=target/packaging/venv
export PATH="$root/$venv/bin:$PATH"
# Windows' files and zip archives have a time: not the clock's but the first that zip knows, as in an FMU.
export SOURCE_DATE_EPOCH=315532800
# Zig's cache stays below target/ too.
export ZIG_GLOBAL_CACHE_DIR=$root/target/packaging/zig CARGO_ZIGBUILD_CACHE_DIR=$root/target/packaging/zigbuild
sdk=$root/target/packaging/sdk

# Installs the linker in target/, for platforms whose Rust target is installed.
prepare() {
    local missing name
    missing=$(missing_triples "${platforms[@]}")
    [ -z "$missing" ] || { echo "$0: Rust's standard library is missing; run: rustup target add" $missing >&2 && exit 1; }
    if ! cmp -s packaging/requirements.txt "$venv/requirements.txt"; then
        echo "== Into $venv:" $(cat packaging/requirements.txt)
        rm -rf "$venv"
        python3 -m venv "$venv"
        "$venv/bin/pip" install --quiet --disable-pip-version-check -r packaging/requirements.txt
        cp packaging/requirements.txt "$venv/requirements.txt"
    fi
    # The linker for Darwin's files; the linker of Rust does not know the names of the newest processors yet.
    mkdir -p "$sdk/usr/lib"
    for name in System c iconv m; do
        sed 's/arm64e\.x1/arm64/g' "$venv"/lib/python3*/site-packages/ziglang/lib/libc/darwin/libSystem.tbd \
            >"$sdk/usr/lib/lib$name.tbd"
    done
    # A library in the tool asks macOS for the time zone; zig has no stub of that framework.
    local framework=$sdk/System/Library/Frameworks/CoreFoundation.framework
    mkdir -p "$framework"
    cat >"$framework/CoreFoundation.tbd" <<'STUB'
--- !tapi-tbd
tbd-version: 4
targets: [ x86_64-macos, arm64-macos ]
install-name: '/System/Library/Frameworks/CoreFoundation.framework/Versions/A/CoreFoundation'
exports:
  - targets: [ x86_64-macos, arm64-macos ]
    symbols: [ _CFRelease, _CFStringGetBytes, _CFStringGetCStringPtr, _CFStringGetLength, _CFTimeZoneCopySystem,
               _CFTimeZoneGetName, _CFTimeZoneResetSystem ]
...
STUB
}

# Runs a cargo command for a triple. The built files do not contain the builder or the place: the same sources give the same
# bytes.
cross() { # TRIPLE COMMAND…
    # The last match counts: the folder of cargo may be in the checkout.
    local flags=("--remap-path-prefix=$root=camdrive" "--remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo")
    # If the sources of the standard library are installed, rustc names them by their folder, else by its commit.
    flags+=("--remap-path-prefix=$(rustc --print sysroot)/lib/rustlib/src/rust=/rustc/$(rustc -vV | sed -n 's/^commit-hash: //p')")
    case $1 in
    # Nothing in a page needs random numbers, which a browser has elsewhere.
    wasm*) flags+=('--cfg=getrandom_backend="unsupported"') ;;
    *-darwin)
        # Stripped by the linker, since it also signs.
        export SDKROOT=$sdk CARGO_PROFILE_RELEASE_STRIP=false CARGO_PROFILE_DIST_STRIP=false
        flags+=(-Clinker=rust-lld -Clinker-flavor=ld64.lld -Clink-arg=-x -Clink-arg=-S)
        ;;
    esac
    CARGO_INCREMENTAL=0 CARGO_ENCODED_RUSTFLAGS=$(IFS=$'\x1f' && echo "${flags[*]}") "${@:2}"
}
