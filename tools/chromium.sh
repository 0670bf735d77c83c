#!/usr/bin/env bash
# Sees to it that a Chromium is there for the browser tests: uses an installed one, else installs
# Debian's when it may. Says so loudly when there is none, and exits 1.
set -euo pipefail

for name in chromium chromium-browser google-chrome google-chrome-stable; do
    if found=$(command -v "$name"); then
        echo "browser tests use $found"
        exit 0
    fi
done

if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "no Chromium: installing Debian's"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium >/dev/null
    command -v chromium
    exit 0
fi

echo "!!! NO CHROMIUM: the browser tests cannot run. On Debian: apt-get install chromium" >&2
exit 1
