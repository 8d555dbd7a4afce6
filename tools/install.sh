#!/usr/bin/env bash
# Makes .venv beside the sources and installs the project in it. Usage: tools/install.sh EXTRA[,EXTRA...]
set -euo pipefail
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "vlpg-edge needs Python 3.11 or newer; set PYTHON=/path/to/python3.11" >&2; exit 1; }
if [ ! -x .venv/bin/pip ]; then
    "$python" -m venv .venv || { echo "Python's venv module is missing; on Debian: apt-get install python3-venv" >&2; exit 1; }
fi
# Reinstall only when the metadata or the wanted extras changed.
stamp=".venv/installed-$(cat setup.cfg pyproject.toml <(echo "$1") | sha256sum | cut -c1-16)"
if [ ! -e "$stamp" ]; then
    # setuptools warns at length that an editable install reads the sources; that is what it is for here.
    PYTHONWARNINGS=ignore .venv/bin/python -m pip install --quiet --disable-pip-version-check --editable ".[$1]"
    touch "$stamp"
fi
