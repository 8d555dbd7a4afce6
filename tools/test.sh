#!/usr/bin/env bash
# Installs into .venv and runs all tests. Arguments go to pytest.
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/install.sh dev
export OPENBLAS_NUM_THREADS=1 ORT_DISABLE_TELEMETRY=1
.venv/bin/ruff check .
# Files, not tests: what a file's tests share is made once.
exec .venv/bin/python -m pytest --numprocesses auto --maxprocesses 4 --dist loadfile "$@"
