#!/usr/bin/env bash
# Does the bundle work on ARM? Makes a small arm64 Debian, installs the bundle in it with its own script, and lets it run
# on an emulated Cortex-A72: the doctor, the int8 towers, a store made here, a recorded search, a drive to
# what it is asked for, with base and host on this machine. Needs root, and a Debian whose package sources are reachable.
# Takes most of an hour; nothing is timed.
#
#   tools/arm64_check.sh [PYTHON [FOLDER]]     PYTHON: 3.11 or 3.13, of Debian 12 or 13 (default: 3.11)
#                                              FOLDER keeps the arm64 system and the recording (default: build/arm64)
set -euo pipefail
cd "$(dirname "$0")/.."
version=${1:-3.11}
case $version in
3.11) debian=bookworm ;;
3.13) debian=trixie ;;
*) echo "the bundle is made for Python 3.11 and 3.13, not $version" >&2; exit 1 ;;
esac
folder=$(realpath -m "${2:-build/arm64}")
system=$folder/$debian
python=.venv/bin/python
[ -x $python ] || { echo "run bash tools/install.sh dev first" >&2; exit 1; }
[ "$(id -u)" = 0 ] || { echo "run it as root: it makes a system of its own and changes into it" >&2; exit 1; }
for tool in mmdebstrap qemu-aarch64-static; do
    command -v $tool >/dev/null || { apt-get install --quiet --yes mmdebstrap qemu-user-static; break; }
done

mkdir -p "$folder"
if [ ! -e "$folder/$debian.made" ]; then
    rm -rf "$system"
    # The package sources of this machine, whatever they are, with that Debian's packages.
    for sources in /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list; do [ -e "$sources" ] && break; done
    here=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
    sed "s/\b$here\b/$debian/g" "$sources" > "$folder/$(basename "$sources")"
    mmdebstrap --quiet --mode=root --variant=extract --architectures=arm64 --include=python3,libstdc++6 \
        $debian "$system" "$folder/$(basename "$sources")"
    for part in bin lib sbin; do [ -e "$system/$part" ] || ln -s usr/$part "$system/$part"; done  # a package's script would
    cp "$(command -v qemu-aarch64-static)" "$system/usr/bin/"
    touch "$folder/$debian.made"
fi

rm -rf "$folder"/bundle
$python -m tools.deploy.command bundle --target aarch64 --python $version --out "$folder/bundle"
tar xzf "$folder"/bundle/*.tar.gz -C "$folder/bundle"
sh "$folder"/bundle/*/install.sh --root "$system"

# A program of the arm64 system. No binfmt is registered: only this one process is emulated. It takes the place of
# the shell, so that $! is the program's: call it in ( ) or with &.
arm() {
    local installed=/opt/vlpg/current
    exec env -i PATH=/usr/bin:/usr/sbin HOME=/tmp ORT_DISABLE_TELEMETRY=1 OPENBLAS_NUM_THREADS=1 \
        PYTHONPATH=$installed/app:$installed/site \
        chroot "$system" /usr/bin/qemu-aarch64-static -cpu cortex-a72 /usr/bin/python3 -s -P "$@" 2> >(grep -v cpuinfo >&2)
}
mkdir -p "$system/proc" "$system/check"
mountpoint -q "$system/proc" || mount -t proc proc "$system/proc"
robot= host= base=
cleanup() {
    for pid in $robot $host $base; do kill "$pid" 2>/dev/null || true; done
    wait
    umount "$system/proc"
}
trap cleanup EXIT

echo "== the doctor, on an emulated Cortex-A72 (its time of a picture is the emulator's)"
(arm -m edge.doctor --no-link) > "$folder/doctor.txt" || true  # it minds the time
cat "$folder/doctor.txt"
grep -q "text tower .* ok" "$folder/doctor.txt"
if grep BAD "$folder/doctor.txt" | grep -v "ms a picture"; then exit 1; fi

echo "== towers, store and a recorded search, against this machine"
$python -m tools.arm64.here prepare "$folder/work"
cp "$folder"/work/{home.vlpg,mission.rec} tools/arm64/there.py "$system/check/"
(arm /check/there.py /check)
cp "$system"/check/{there.npz,there.vlpg} "$folder/work/"
$python -m tools.arm64.here compare "$folder/work"

echo "== a robot there; its base and host here, and the memory that was made here"
endpoint=tcp/127.0.0.1:$($python -c 'from tools.demo.processes import free_port; print(free_port())')
ORT_DISABLE_TELEMETRY=1 $python -m host.node --listen "$endpoint" --no-multicast-scouting & host=$!
# Time passes slowly at the base: the emulator needs seconds for a control step.
ORT_DISABLE_TELEMETRY=1 $python -m firmware_sim.node --home tools/arm64/flat.json --speed 0.04 \
    --connect "$endpoint" --no-multicast-scouting & base=$!
rm -f "$system"/check/talk.vlpg*
cp "$folder/work/home.vlpg" "$system/check/talk.vlpg"
arm -m edge.node --wait --offload host --memory /check/talk.vlpg --connect "$endpoint" --no-multicast-scouting & robot=$!
heard="offload host, a host is there" answer=
for _ in $(seq 60); do
    sleep 2
    answer=$($python -m tools.cli status --connect "$endpoint" --no-multicast-scouting 2>/dev/null) || continue
    ! grep -q "$heard" <<<"$answer" || break
done
echo "$answer"
grep -q "$heard" <<<"$answer"
found=0  # or 1: it looked, and says no
timeout 1h $python -m tools.cli find plant --search --connect "$endpoint" --no-multicast-scouting || found=$?
[ "$found" -le 1 ]
echo "== the bundle works on emulated ARM"
