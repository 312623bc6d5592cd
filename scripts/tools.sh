# Sourced by the scripts beside it: enters the repository and makes sure that a C compiler and a Rust new enough
# are there. Never asks; says plainly what is missing when it cannot be installed.

cd "$(dirname "${BASH_SOURCE[0]}")/.."
export PATH="${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif have sudo && sudo -n true 2>/dev/null; then
        sudo -n "$@"
    else
        return 1
    fi
}

# install_packages NAME...: Debian packages, without questions.
install_packages() {
    have apt-get || return 1
    say "Installing: $*"
    as_root apt-get update -qq >&2 || say "warning: the package lists could not be refreshed"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >&2
}

# Pictures without a graphics card: a Vulkan driver that draws on the processor, unless there is some driver.
ensure_graphics() {
    local drivers=(/usr/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json)
    [ "$(uname -s)" = Linux ] && [ -z "${VK_DRIVER_FILES:-}" ] || return 0
    for driver in "${drivers[@]}"; do
        [ -e "$driver" ] && return 0
    done
    install_packages mesa-vulkan-drivers libvulkan1 \
        || say "warning: no Vulkan driver; install mesa-vulkan-drivers and libvulkan1, or what draws pictures will fail"
}

# The least Rust that the crate builds with, from Cargo.toml.
least_rust() { sed -n 's/^rust-version *= *"\(.*\)"/\1/p' Cargo.toml; }

rust_is_new_enough() {
    have cargo && have rustc || return 1
    local found least
    found=$(rustc --version 2>/dev/null | cut -d' ' -f2) || return 1
    least=$(least_rust)
    [ -n "$found" ] && [ "$(printf '%s\n%s\n' "$least" "$found" | sort -V | head -n 1)" = "$least" ]
}

install_rust() {
    if have rustup; then
        say "Updating Rust with rustup"
        rustup toolchain install stable --profile minimal -c rustfmt -c clippy >&2 || return 1
        export RUSTUP_TOOLCHAIN=stable
        return
    fi
    have curl || install_packages curl ca-certificates || return 1
    say "Installing Rust with rustup"
    local installer
    installer=$(mktemp)
    curl --proto '=https' --tlsv1.2 -fsSL https://sh.rustup.rs -o "$installer" \
        && sh "$installer" -y -q --no-modify-path --profile minimal -c rustfmt -c clippy >&2
    local result=$?
    rm -f "$installer"
    return $result
}

if ! have cc || ! have g++; then
    install_packages gcc g++ libc6-dev || fail "a C and C++ compiler is missing and could not be installed;" \
        "install gcc and g++ (Debian: apt-get install gcc g++) and run this again"
fi
if ! rust_is_new_enough; then
    install_rust && rust_is_new_enough || fail "Rust $(least_rust) or newer is missing and could not be installed" \
        "(is https://sh.rustup.rs reachable?); install it from https://rustup.rs and run this again"
fi
