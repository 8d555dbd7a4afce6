#!/usr/bin/env bash
# Is a 512 MB board enough? Boots a whole emulated arm64 machine (two Cortex-A72, 512 MB), installs the bundle in it with
# its own install.sh, lives through a recorded tour and search under the budget's limit of memory, and once under one that
# is too low, which must fail. Then systemd takes over and must start the service, start it anew when it hangs, leave it
# alone when the same is installed again, and take an update and the way back. Needs root, and a Debian whose package
# sources are reachable. Takes an hour or two, as the emulator needs two seconds for a picture.
#
#   tools/arm64_machine.sh [FOLDER]     FOLDER keeps the machine's files (default: build/arm64-machine)
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(realpath -m "${1:-build/arm64-machine}")
root=$folder/machine
python=.venv/bin/python
[ -x $python ] || { echo "run bash tools/install.sh dev first" >&2; exit 1; }
[ "$(id -u)" = 0 ] || { echo "run it as root: it makes a system of its own" >&2; exit 1; }
packages="mmdebstrap qemu-system-arm e2fsprogs cpio kmod"
for tool in mmdebstrap qemu-system-aarch64 mke2fs cpio depmod; do
    command -v $tool >/dev/null || { apt-get install --quiet --yes --no-install-recommends $packages; break; }
done

mkdir -p "$folder"
if [ ! -e "$folder/machine.made" ]; then
    rm -rf "$root"
    # The package sources of this machine, whatever they are.
    for sources in /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list; do [ -e "$sources" ] && break; done
    mmdebstrap --quiet --mode=root --variant=extract --architectures=arm64 \
        --include=python3,libstdc++6,passwd,dash,coreutils,findutils,sed,grep,mount,busybox-static,systemd,linux-image-cloud-arm64 \
        bookworm "$root" "$sources"
    # Nothing was configured: what the packages' scripts would have made.
    echo "root:x:0:0:root:/root:/bin/sh" > "$root/etc/passwd"
    echo "root:x:0:" > "$root/etc/group"
    tr -d - < /proc/sys/kernel/random/uuid > "$root/etc/machine-id"  # without one systemd asks about a new system
    ln -s /dev/null "$root/etc/systemd/system/serial-getty@ttyAMA0.service"  # nobody is to log in at the console
    touch "$folder/machine.made"
fi

# The kernel's drivers for the disk are modules: a first root in memory loads them and goes on to the disk.
first=$folder/first
rm -rf "$first"
mkdir -p "$first"/{bin,proc,sys,dev,disk,modules}
cp "$root/bin/busybox" "$first/bin/"
version=$(basename "$root"/lib/modules/*)
needed() { # module names, each after those that it needs
    local name=$1 path dependency
    path=$(grep -m1 "/${name//_/[-_]}\.ko:" "$root/lib/modules/$version/modules.dep") || return 0  # built in
    for dependency in ${path#*:}; do
        dependency=$(basename "$dependency" .ko)
        needed "$dependency"
    done
    path=${path%%:*}
    [ -e "$first/modules/$(basename "$path")" ] || {
        cp "$root/lib/modules/$version/$path" "$first/modules/"
        echo "insmod /modules/$(basename "$path")" >> "$first/load"
    }
}
[ -e "$root/lib/modules/$version/modules.dep" ] || depmod --basedir "$root" "$version"
touch "$first/load"
for module in virtio_pci virtio_mmio virtio_blk ext4; do needed $module; done
{
    echo '#!/bin/busybox sh'
    echo '/bin/busybox --install -s /bin; mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev'
    cat "$first/load"
    echo 'mount -t ext4 /dev/vda /disk && exec switch_root /disk /check/init'
    echo 'echo "the disk cannot be mounted"; poweroff -f'
} > "$first/init"
chmod 755 "$first/init"
(cd "$first" && find . | cpio --quiet --create --format=newc | gzip) > "$folder/first.gz"

echo "== the bundles and the recording"
rm -rf "$folder/bundle"
for offload in "" --offload; do
    $python -m tools.deploy.command bundle --target aarch64 --python 3.11 $offload --out "$folder/bundle"
done
$python -m tools.arm64.here prepare "$folder/work"
rm -rf "$root"/{check,opt/vlpg}
mkdir -p "$root"/{check,proc,sys,dev,tmp,run}
for bundle in "$folder"/bundle/*.tar.gz; do tar xzf "$bundle" -C "$root/check"; done
cp "$folder/work/mission.rec" "$root/check/"
cat > "$root/check/init" <<'END'
#!/bin/sh
# The machine's first program: what it prints is read from its console. systemd follows it, with a part of its own.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev 2>/dev/null
mkdir -p /dev/shm; mount -t tmpfs tmp /dev/shm; mount -t tmpfs tmp /run; mount -t cgroup2 cgroup /sys/fs/cgroup
echo +memory > /sys/fs/cgroup/cgroup.subtree_control
busybox ip link set lo up
grep MemTotal /proc/meminfo
run() { echo "MACHINE: $1"; shift; "$@"; echo "MACHINE: exit code $?"; }
bench="/opt/vlpg/bin/vlpg-bench mission --recording /check/mission.rec --budget pi-zero-2w"
run install sh /check/vlpg-edge-*-cp311/install.sh
touch /opt/vlpg/current/failed  # as if that had been broken off
run "too little" $bench --enforce 60
run enough $bench --enforce
exec /lib/systemd/systemd --unit=multi-user.target
END
cat > "$root/check/service" <<'END'
#!/bin/sh
# What systemd makes of the unit, which the installation has left to be started with the machine.
run() { echo "MACHINE: $1"; shift; "$@"; echo "MACHINE: exit code $?"; }
show() { systemctl show --value --property "$1" vlpg-robot.service; }
started() { # this often, and it has said that it is ready
    for _ in $(seq 100); do
        sleep 3
        [ "$(show NRestarts)" -lt "$1" ] || ! systemctl is-active --quiet vlpg-robot.service || break
    done
    grep . /sys/fs/cgroup/system.slice/vlpg-robot.service/memory.max /sys/fs/cgroup/system.slice/vlpg-robot.service/memory.peak
    systemctl is-active vlpg-robot.service && [ "$(show NRestarts)" = "$1" ] && ! [ -e /opt/vlpg/current/failed ] ||
        ! journalctl --unit vlpg-robot.service
}
same() {
    before=$(show MainPID)
    sh /check/vlpg-edge-*-cp311/install.sh && [ "$(show MainPID)" = "$before" ]
}
release() { # with what it is to be started
    "$@" && systemctl is-active vlpg-robot.service && grep VLPG_RELEASE /opt/vlpg/current/release.env
}
run "the service" started 0
kill -STOP "$(show MainPID)"
run "it hangs" started 1
run "the same again" same
run "an update" release sh /check/vlpg-edge-*-offload/install.sh
run "back" release sh /opt/vlpg/current/install.sh --rollback
END
mkdir -p "$root/etc/systemd/system/multi-user.target.wants"
cat > "$root/etc/systemd/system/check.service" <<'END'
[Service]
Type=idle
ExecStart=/check/service
ExecStopPost=/bin/busybox poweroff -f
StandardOutput=tty
StandardError=tty
TTYPath=/dev/console
END
ln -sf ../check.service "$root/etc/systemd/system/multi-user.target.wants/check.service"
chmod 755 "$root/check/init" "$root/check/service"
rm -f "$folder/disk.ext4"
mke2fs -q -t ext4 -d "$root" "$folder/disk.ext4" 3G

echo "== the machine"
timeout 6h qemu-system-aarch64 -M virt -cpu cortex-a72 -smp 2 -m 512 -nographic -no-reboot \
    -kernel "$root"/boot/vmlinuz-* -initrd "$folder/first.gz" -append "console=ttyAMA0 quiet systemd.show_status=no panic=-1" \
    -drive file="$folder/disk.ext4",format=raw,if=virtio,cache=unsafe -nic none | sed -u 's,\r,,' | tee "$folder/machine.txt"
codes=$(sed -n 's/^MACHINE: exit code //p' "$folder/machine.txt" | tr '\n' ' ')
[ "$codes" = "0 1 0 0 0 0 0 0 " ] || { echo "the machine's exit codes are $codes, not 0 1 0 0 0 0 0 0" >&2; exit 1; }
echo "== a 512 MB machine is enough, and 60 MB are not; its systemd keeps the robot running"
