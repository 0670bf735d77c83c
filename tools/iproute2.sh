#!/usr/bin/env bash
# Sees to it that iproute2 is there for the tests on real links, which run in network namespaces: uses an
# installed one, else installs Debian's when it may. Says so loudly when there is none, and exits 1.
set -euo pipefail

if found=$(command -v ip); then
    echo "tests on real links use $found"
    exit 0
fi

if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "no iproute2: installing Debian's"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq && apt-get install -y -qq --no-install-recommends iproute2 >/dev/null
    command -v ip
    exit 0
fi

echo "!!! NO IPROUTE2: the tests on real links cannot run. On Debian: apt-get install iproute2" >&2
exit 1
