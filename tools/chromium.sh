#!/usr/bin/env bash
# Sees to it that a Chromium is there for the browser tests: Chromium's shell without a window where it is
# installed or may be (it needs a third of the time), else an installed browser. Says so loudly when there is none,
# and exits 1.
set -euo pipefail

shell=chromium-headless-shell

install() {
    echo "installing Debian's $1"
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends "$1" >/dev/null; } 2>/dev/null
}

if ! command -v $shell >/dev/null && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    install $shell || echo "it cannot be installed"
fi

for name in $shell chromium chromium-browser google-chrome google-chrome-stable; do
    if found=$(command -v "$name"); then
        echo "browser tests use $found"
        exit 0
    fi
done

echo "!!! NO CHROMIUM: the browser tests cannot run. On Debian: apt-get install $shell" >&2
exit 1
