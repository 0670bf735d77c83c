#!/usr/bin/env bash
# Pins every dependency with hashes: requirements.txt to run (real machines included), requirements-dev.txt to build and test,
# requirements-pip.txt to install them. Resolves against the default index alone, so that the files hold no address and the hashes of all
# platforms. Usage: tools/lock.sh PYTHON [pip-compile options, as --upgrade]
set -euo pipefail
cd "$(dirname "$0")/.."

python=$1
shift
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
"$python" -m venv "$tools"
"$tools/bin/pip" install --quiet pip-tools

export CUSTOM_COMPILE_COMMAND="make lock" PIP_FIND_LINKS="" PIP_EXTRA_INDEX_URL=""
options=(--quiet --generate-hashes --strip-extras --resolver=backtracking
    --no-emit-index-url --no-emit-find-links --no-emit-trusted-host)
"$tools/bin/pip-compile" "${options[@]}" "$@" --extra opcua --output-file requirements.txt pyproject.toml
"$tools/bin/pip-compile" "${options[@]}" "$@" --extra dev --constraint requirements.txt \
    --output-file requirements-dev.txt pyproject.toml
echo pip | "$tools/bin/pip-compile" "${options[@]}" "$@" --allow-unsafe --output-file requirements-pip.txt -
