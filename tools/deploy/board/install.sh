#!/bin/sh
# Installs the robot from the folder that this script lies in, without a network. Run it as root on the board.
#
#   install.sh               install and start; the version before is kept
#   install.sh --rollback    go back to the version before
#   install.sh --root DIR    install below DIR, as into a mounted card, whose system makes the user when it boots
set -eu
umask 022  # the service's user must be able to read what root installs
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
root= rollback=
while [ $# -gt 0 ]; do
    case $1 in
    --rollback) rollback=1 ;;
    --root) root=${2:?--root needs a folder}; shift ;;
    *) sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
    esac
    shift
done
fail() { echo "install.sh: $1" >&2; exit 1; }
python=$(command -v python@PYTHON@ || command -v python3) || fail "there is no Python; install python@PYTHON@"
home=/opt/vlpg
base=$root$home

restart() {
    [ -z "$root" ] && [ -d /run/systemd/system ] || return 0
    systemctl daemon-reload
    systemctl restart vlpg-robot.service || fail "the robot does not start; see: journalctl -u vlpg-robot"
}

# Makes a link point elsewhere in one step: who reads it meanwhile sees the old or the new one.
point() { ln -sfn "$2" "$1.new" && mv -T "$1.new" "$1"; }

if [ -n "$rollback" ]; then
    [ -L "$base/previous" ] || fail "there is no version before this one"
    now=$(readlink "$base/current") before=$(readlink "$base/previous")
    point "$base/current" "$before"
    point "$base/previous" "$now"
    restart
    echo "back at ${before#releases/}"
    exit
fi

if [ -z "$root" ]; then
    [ "$(id -u)" = 0 ] || fail "run it as root"
    [ "$(uname -m)" = @MACHINE@ ] || fail "this bundle is for @MACHINE@, and this board is $(uname -m)"
    found=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    [ "$found" = @PYTHON@ ] || fail "this bundle is for Python @PYTHON@, and $python is $found; make one with --python $found"
fi
release=$(cat "$here/release")
folder=$base/releases/$release
if [ ! -e "$folder/complete" ]; then
    (cd "$here" && sha256sum --quiet --check wheels.sha256) || fail "the bundle is damaged; copy it again"
    rm -rf "$folder"
    mkdir -p "$folder/site"
    for wheel in "$here"/wheels/*.whl; do
        "$python" -m zipfile -e "$wheel" "$folder/site"
    done
    cp -R "$here/app" "$here/about.json" "$here/release.env" "$folder/"
    "$python" -m compileall -q -j 0 "$folder/site" "$folder/app" >/dev/null || true  # a package may carry files for other Pythons
    touch "$folder/complete"
fi

mkdir -p "$base/bin" "$root/etc/vlpg" "$root/etc/systemd/system/multi-user.target.wants" "$root/etc/sysusers.d"
for part in node:vlpg-robot doctor:vlpg-doctor bench:vlpg-bench; do
    cat > "$base/bin/${part#*:}" <<END
#!/bin/sh
# The installed robot's own packages and no others. Telemetry of ONNX Runtime off, one thread for BLAS.
here=\$(CDPATH= cd -- "\$(dirname -- "\$0")/../current" && pwd -P)
export PYTHONPATH=\$here/app:\$here/site ORT_DISABLE_TELEMETRY=1 OPENBLAS_NUM_THREADS=1
exec "\$(command -v python@PYTHON@ || command -v python3)" -s -P -m edge.${part%:*} "\$@"
END
    chmod 755 "$base/bin/${part#*:}"
done
[ -e "$root/etc/vlpg/robot.env" ] || cp "$here/robot.env" "$root/etc/vlpg/robot.env"
cp "$here/vlpg-robot.service" "$root/etc/systemd/system/vlpg-robot.service"
ln -sfn ../vlpg-robot.service "$root/etc/systemd/system/multi-user.target.wants/vlpg-robot.service"
echo 'u vlpg - "vlpg-edge robot" /var/lib/vlpg /usr/sbin/nologin' > "$root/etc/sysusers.d/vlpg.conf"
if [ -z "$root" ] && ! id vlpg >/dev/null 2>&1; then
    useradd --system --home-dir /var/lib/vlpg --shell /usr/sbin/nologin vlpg
fi

now=$(readlink "$base/current" || true)
if [ "$now" != "releases/$release" ]; then
    [ -z "$now" ] || point "$base/previous" "$now"
    point "$base/current" "releases/$release"
fi
for old in "$base"/releases/*; do
    case releases/${old##*/} in
    "$(readlink "$base/current")" | "$(readlink "$base/previous" || true)") ;;
    *) rm -rf "$old" ;;
    esac
done
chmod -R a+rX "$base"
restart
echo "installed $release in $home"
