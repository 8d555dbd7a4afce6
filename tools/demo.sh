#!/usr/bin/env bash
# Installs into .venv and runs the demo: map a furnished home, then find objects in it. Arguments go to `vlpg demo`.
set -euo pipefail
cd "$(dirname "$0")/.."
bash tools/install.sh sim,host,tools
exec .venv/bin/vlpg demo "$@"
