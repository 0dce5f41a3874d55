#!/bin/sh
# Makes the virtual environment in $1 and installs Attune into it: $2 is "." or, with extras, ".[dev]".
# Debian packages are installed only if they are missing, and only with a message that says so.
set -eu

venv=$1
what=$2
python=${PYTHON:-python3}

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || {
    echo "Attune needs Python 3.11 or newer, and '$python' is not. Set it: make PYTHON=/path/to/python3.11 ..." >&2
    exit 1
}

has_library() { ldconfig -p 2>/dev/null | grep -q "$1" || /sbin/ldconfig -p 2>/dev/null | grep -q "$1"; }

# Name the packages that are missing: "required" ones stop the installation, the others switch something off.
required=''
optional=''
"$python" -c 'import ensurepip, venv' 2>/dev/null || required="$required python3-venv"
has_library libportaudio.so.2 || optional="$optional libportaudio2"

install_packages() {
    # $1: packages, $2: what they are for. Fails where they cannot be installed.
    command -v apt-get >/dev/null || return 1
    if [ "$(id -u)" = 0 ]; then root=''; elif sudo -n true 2>/dev/null; then root='sudo -n'; else return 1; fi
    echo "Installing the Debian package(s)$1 ($2)."
    $root apt-get update -qq && DEBIAN_FRONTEND=noninteractive $root apt-get install -y -qq $1 >/dev/null
}

if [ -n "$required" ] && ! install_packages "$required" "for the virtual environment"; then
    echo "Attune needs the Debian package(s)$required. Install them: sudo apt-get install$required" >&2
    exit 1
fi
if [ -n "$optional" ] && ! install_packages "$optional" "for microphone and loudspeaker"; then
    echo "Without$optional, microphone and loudspeaker are off. Install: sudo apt-get install$optional" >&2
fi

[ -x "$venv/bin/python" ] || { echo "Making $venv"; "$python" -m venv "$venv"; }
echo "Installing Attune and what it needs into $venv (once): $what"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check -c constraints.txt -e "$what"
