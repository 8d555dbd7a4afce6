#!/bin/sh
# Installs the robot from the folder that this script lies in, without a network. Run it as root on the board.
#
#   install.sh               install and start; the version before is kept
#   install.sh --rollback    go back to the version before; what is installed has this script as well
#   install.sh --root DIR    install below DIR, as into a mounted card, whose system makes the user when it boots
set -eu
umask 022  # the service's user must be able to read what root installs
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
root= rollback= changed=
while [ $# -gt 0 ]; do
    case $1 in
    --rollback) rollback=1 ;;
    --root) root=${2:?--root needs a folder}; shift ;;
    *) sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
    esac
    shift
done
fail() { echo "install.sh: $1" >&2; exit 1; }
home=/opt/vlpg
base=$root$home

# Makes a link point elsewhere in one step: who reads it meanwhile sees the old or the new one.
point() { ln -sfn "$2" "$1.new" && mv -T "$1.new" "$1"; }

# Runs what is current, under its own limits. What never starts is no version to go back to: the unit takes the mark off,
# whenever that is. A robot that runs as it should is not disturbed.
activate() {
    unit=$root/etc/systemd/system/vlpg-robot.service
    if [ -n "$root" ] || ! [ -d /run/systemd/system ]; then
        cp "$base/current/vlpg-robot.service" "$unit"
    elif [ -n "$changed" ] || [ "$(cat "$base/current/vlpg-robot.service")" != "$(cat "$unit")" ] ||
        ! systemctl is-active --quiet vlpg-robot.service; then
        touch "$base/current/failed"
        cp "$base/current/vlpg-robot.service" "$unit"
        systemctl daemon-reload
        systemctl restart vlpg-robot.service ||
            fail "the robot does not start; journalctl -u vlpg-robot says why, $home/current/install.sh --rollback goes back"
    fi
}

if [ -n "$rollback" ]; then
    [ -L "$base/previous" ] || fail "there is no version before this one"
    now=$(readlink "$base/current") before=$(readlink "$base/previous")
    [ -n "$root" ] || "$base/$before/bin/vlpg-robot" --help >/dev/null ||
        fail "the version before does not run here any more; it was made for $(cat "$base/$before/about.json")"
    point "$base/current" "$before"
    [ -e "$base/$now/failed" ] || point "$base/previous" "$now"
    changed=1
    activate
    [ "$(readlink "$base/previous")" != "$before" ] || rm "$base/previous"
    echo "back at ${before#releases/}"
    exit
fi

[ -e "$here/release" ] || fail "there is nothing to install here, only --rollback; a bundle's own install.sh installs that"

# The first Python that runs: a name in the PATH may be a version manager's, of one that is not there. -I: this is root,
# and what lies in the folder it stands in is not to be imported.
for python in python@PYTHON@ python3 none; do
    found=$("$python" -I -c 'import struct, sys; print("%d.%d," % sys.version_info[:2], 8 * struct.calcsize("P"), "bit")' 2>/dev/null) && break
done
[ "$python" != none ] || fail "there is no Python; install python@PYTHON@"
if [ -z "$root" ]; then
    [ "$(id -u)" = 0 ] || fail "run it as root"
    [ "$(uname -m)" = @MACHINE@ ] || fail "this bundle is for @MACHINE@, and this board is $(uname -m)"
    [ "$found" = "@PYTHON@, 64 bit" ] || fail "this bundle is for Python @PYTHON@, 64 bit, and $python is $found; make another one, with --python"
fi
release=$(cat "$here/release")
folder=$base/releases/$release
if ! [ -e "$folder/complete" ] || ! (cd "$folder" && sha256sum --quiet --check sums) >/dev/null 2>&1; then
    [ "$(sha256sum < "$here/files.sha256" | cut -c 1-12)" = "$release" ] &&
        (cd "$here" && sha256sum --quiet --check files.sha256) || fail "the bundle is damaged; copy it again"
    new=$folder.new  # what is damaged may run, and is better than nothing if this one cannot be written either
    trap 'rm -rf "$new" "$new.sums"' EXIT  # a half takes room, and is of no use
    rm -rf "$new" "$folder.old"
    mkdir -p "$new/site" "$new/bin"
    for wheel in "$here"/wheels/*.whl; do
        "$python" -I -m zipfile -e "$wheel" "$new/site"
    done
    cp -R "$here/app" "$here/about.json" "$here/release.env" "$here/vlpg-robot.service" "$here/install.sh" "$new/"
    for part in node:vlpg-robot doctor:vlpg-doctor bench:vlpg-bench reindex:vlpg-reindex; do
        made=  # the doctor is asked about this release; your own options come after, and win
        [ "$part" != doctor:vlpg-doctor ] || made=$(sed -n 's/^VLPG_RELEASE=//p' "$here/release.env")
        cat > "$new/bin/${part#*:}" <<END
#!/bin/sh
# The installed robot's own packages and no others. Telemetry of ONNX Runtime off, one thread for BLAS, and without the
# documentation in the code, which takes 2 MB.
here=\$(CDPATH= cd -P -- "\$(dirname -- "\$0")" && cd .. && pwd -P)
export PYTHONPATH=\$here/app:\$here/site ORT_DISABLE_TELEMETRY=1 OPENBLAS_NUM_THREADS=1
python=\$(command -v python@PYTHON@) || {
    python=\$(command -v python3) &&
        "\$python" -I -c 'import sys; sys.exit(sys.version_info[:2] != tuple(map(int, "@PYTHON@".split("."))))' || {
        echo "\$0: there is no Python @PYTHON@ any more; install it, or the bundle for the Python that there is" >&2
        exit 2
    }
}
exec "\$python" -OO -s -P -m edge.${part%:*} $made "\$@"
END
        chmod 755 "$new/bin/${part#*:}"
    done
    (cd "$new" && find . -type f -exec sha256sum {} +) > "$new.sums"
    mv "$new.sums" "$new/sums"
    sync -f "$new"  # or a power cut may leave a complete version of empty files
    touch "$new/complete"
    [ ! -e "$folder" ] || mv "$folder" "$folder.old"
    mv "$new" "$folder"
    rm -rf "$folder.old"
    trap - EXIT
    changed=1
fi
if [ "$found" != "@PYTHON@, 64 bit" ]; then
    echo "install.sh: without a Python @PYTHON@ here the code is not compiled; until this is run on the board, too," \
        "the robot takes longer to start, and more memory" >&2
elif ! [ -e "$folder/compiled" ]; then
    # A package may carry files for other Pythons. One file at a time: a robot may be running beside it.
    "$python" -I -m compileall -q -o 2 "$folder/site" "$folder/app" >/dev/null || true
    sync -f "$folder"
    touch "$folder/compiled"
fi

mkdir -p "$root/etc/vlpg" "$root/etc/systemd/system/multi-user.target.wants" "$root/etc/sysusers.d"
[ -e "$root/etc/vlpg/robot.env" ] || cp "$here/robot.env" "$root/etc/vlpg/robot.env"
ln -sfn ../vlpg-robot.service "$root/etc/systemd/system/multi-user.target.wants/vlpg-robot.service"
echo 'u vlpg - "vlpg-edge robot" /var/lib/vlpg /usr/sbin/nologin' > "$root/etc/sysusers.d/vlpg.conf"
if [ -n "$root" ]; then
    rm -f "$root/etc/.updated"  # else a system that has booted before does not look for new users
elif ! id vlpg >/dev/null 2>&1; then
    useradd --system --home-dir /var/lib/vlpg --shell /usr/sbin/nologin vlpg
fi

now=$(readlink "$base/current" || true)
if [ "$now" != "releases/$release" ]; then
    changed=1
    [ -z "$now" ] || [ -e "$base/current/failed" ] || point "$base/previous" "$now"
    point "$base/current" "releases/$release"
    [ "$(readlink "$base/previous" || true)" != "releases/$release" ] || rm "$base/previous"
fi
[ -L "$base/bin" ] || rm -rf "$base/bin"
point "$base/bin" current/bin
for old in "$base"/releases/*; do
    case releases/${old##*/} in
    "$(readlink "$base/current")" | "$(readlink "$base/previous" || true)") ;;
    *) rm -rf "$old" ;;
    esac
done
chmod -R a+rX "$base"
activate
echo "installed $release in $home"
