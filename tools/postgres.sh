#!/usr/bin/env bash
# Sees to it that a PostgreSQL is there for the tests, which start a server of their own from it: uses an
# installed one, else installs Debian's when it may. Says so loudly when there is none, and exits 1.
set -euo pipefail

find_it() {
    for found in /usr/lib/postgresql/*/bin/pg_ctl "$(command -v pg_ctl || true)"; do
        if [ -x "$found" ]; then
            echo "tests on PostgreSQL use $found"
            return 0
        fi
    done
    return 1
}

find_it && exit 0

if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "no PostgreSQL: installing Debian's"
    export DEBIAN_FRONTEND=noninteractive
    # Only what comes with the server: no cluster of the system's own that would run and take a port.
    mkdir -p /etc/postgresql-common
    [ -e /etc/postgresql-common/createcluster.conf ] ||
        echo "create_main_cluster = false" >/etc/postgresql-common/createcluster.conf
    apt-get update -qq && apt-get install -y -qq --no-install-recommends postgresql >/dev/null
    find_it && exit 0
fi

echo "!!! NO POSTGRESQL: the tests on it cannot run. On Debian: apt-get install postgresql" >&2
exit 1
