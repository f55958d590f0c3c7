#!/bin/sh
# Installs what building and rendering need and a Debian machine may lack:
#   a C compiler (some crates carry C), a Vulkan loader, and Mesa's software
#   driver where no Vulkan driver is installed; Node.js 18 or later and npm, for the web page.
#   With "test": Chromium, which looks at the page; Python's venv and the packages of the
#   tests in Python, in target/python-venv; nginx; what the window's test looks at it with: an
#   X server without a screen, hands, what they copied, and the libraries that windows are made with (a desktop
#   has those).
# Does nothing, and needs no rights, where everything is there.
set -eu

command -v cargo >/dev/null || {
    echo "setup: cargo is missing; install Rust 1.95 or later first" >&2
    exit 2
}

packages=""
command -v cc >/dev/null || packages="$packages build-essential"
/sbin/ldconfig -p | grep -q 'libvulkan\.so\.1' || packages="$packages libvulkan1"
if [ -z "${VK_DRIVER_FILES:-}" ] &&
    ! find /usr/share/vulkan/icd.d /etc/vulkan/icd.d -name '*.json' 2>/dev/null | grep -q .; then
    packages="$packages mesa-vulkan-drivers"
fi
command -v node >/dev/null || packages="$packages nodejs"
command -v npm >/dev/null || packages="$packages npm"
if [ "${1:-}" = test ]; then
    [ -x "${CHROMIUM:-/usr/bin/chromium}" ] || packages="$packages chromium"
    command -v python3 >/dev/null || packages="$packages python3"
    python3 -c 'import ensurepip, venv' 2>/dev/null || packages="$packages python3-venv"
    [ -x /usr/sbin/nginx ] || command -v nginx >/dev/null || packages="$packages nginx-light"
    command -v Xvfb >/dev/null || packages="$packages xvfb"
    command -v xdotool >/dev/null || packages="$packages xdotool"
    command -v xclip >/dev/null || packages="$packages xclip"
    /sbin/ldconfig -p | grep -q 'libX11-xcb\.so\.1' || packages="$packages libx11-6 libx11-xcb1"
    /sbin/ldconfig -p | grep -q 'libXcursor\.so\.1' || packages="$packages libxcursor1"
    /sbin/ldconfig -p | grep -q 'libXi\.so\.6' || packages="$packages libxi6"
    /sbin/ldconfig -p | grep -q 'libxkbcommon-x11\.so\.0' || packages="$packages libxkbcommon-x11-0"
fi

if [ -n "$packages" ]; then
    echo "setup: installing$packages"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root="sudo"
    # shellcheck disable=SC2086 # the list is meant to be split
    $as_root apt-get update -qq && $as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends $packages || {
        echo "setup: could not install$packages; install them by hand and try again" >&2
        exit 2
    }
fi

node -e 'process.exit(Number(process.versions.node.split(".")[0]) >= 18 ? 0 : 1)' || {
    echo "setup: Node.js is $(node --version); install version 18 or later first" >&2
    exit 2
}

if [ "${1:-}" = test ]; then
    venv=target/python-venv
    stamp="$venv/requirements.installed"
    if ! cmp -s tests/requirements.txt "$stamp" 2>/dev/null; then
        echo "setup: installing the Python packages of the foreign-client test"
        python3 -m venv "$venv"
        "$venv/bin/pip" install --quiet --disable-pip-version-check -r tests/requirements.txt
        cp tests/requirements.txt "$stamp"
    fi
fi
