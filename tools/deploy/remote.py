"""A board that is reached over ssh: what it is, what it has of a bundle, and what is run there."""

import hashlib
import re
import shlex
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from edge.budget import allowance
from models.manifest import sha256
from tools.deploy.bundle import pack
from tools.deploy.target import MACHINES, PYTHONS, DeployError, Target

FOLDER = "vlpg-bundle"  # in the user's home on the board: the bundle that was last sent, kept for the next
MEASURED = "vlpg-bench"  # there, too: what the benchmarks there use, and found
FIRST_DISK, NEXT_DISK = 900, 450  # MB: the bundle and two installed versions; one more version, of three for a while
STORE = "/var/lib/vlpg/home.vlpg"  # of the installed robot, as in its unit; for root to read
LIBC = (2, 28)  # of the system that the locked wheels are made for, at least
CLOCK = 300.0  # s that the board's may differ by from here
SSH = "ssh -o ConnectTimeout=10 -o BatchMode=yes -o ServerAliveInterval=15"

_PROBE = """
uname -m | sed 's/^/machine /'
getconf LONG_BIT | sed 's/^/bits /'
getconf GNU_LIBC_VERSION | sed 's/^glibc /libc /'
for pid in $(cat /sys/fs/cgroup/system.slice/vlpg-robot.service/cgroup.procs 2>/dev/null); do
    awk '/^RssAnon/ { print "robot", int($2 / 1024) }' /proc/$pid/status
done
test -e /opt/vlpg/current && echo installed yes
([ "$(id -u)" = 0 ] || sudo -n true) 2>/dev/null && echo root yes
(python3.13 -V || true) 2>/dev/null; (python3.11 -V || true) 2>/dev/null; (python3 -V || true) 2>/dev/null
df -Pm "$HOME" /opt 2>/dev/null | awk 'NR > 1 { print "disk", $4 }'
awk '/^MemAvailable/ { print "memory", int($2 / 1024) }' /proc/meminfo
awk -F: '/^(Features|flags)/ { print "features" $2; exit }' /proc/cpuinfo
date +'clock %s'
"""


@dataclass(frozen=True, slots=True)
class Facts:
    """What a board is."""

    machine: str
    bits: int  # of its programs, which may be 32 on a processor of 64
    libc: tuple[int, int]  # version of glibc; (0, 0) with another C library
    installed: bool  # whether some version of the robot is
    root: bool  # whether we may act as root without being asked for a password
    pythons: tuple[str, ...]  # of those that bundles are made for
    disk: float  # MB free where the bundle and the robot go
    memory: float  # MB available, or taken by the robot for itself, which an update ends
    features: frozenset[str]  # of its processor, as its kernel names them
    clock: float  # s since 1970, less here

    def target(self, offload: bool) -> Target:
        """What a bundle for it must be made for. Raises DeployError when there is none, or the board has no room."""
        disk, memory = NEXT_DISK if self.installed else FIRST_DISK, allowance(text=not offload)
        if self.machine not in MACHINES:
            raise DeployError(f"the board is {self.machine}; bundles are for {' or '.join(MACHINES)}")
        if self.bits != 64 or self.libc < LIBC:
            system = f"of {self.bits} bit, with glibc {'.'.join(map(str, self.libc))}"
            raise DeployError(f"the board's system is {system}; it takes one of 64 bit, with glibc 2.28 or newer")
        if not self.root:
            raise DeployError("there is no sudo, or it asks for a password; let it not, or push to root@")
        if not self.pythons:
            raise DeployError(f"the board has no Python {' or '.join(PYTHONS)}; install one of them there")
        if self.disk < disk:
            raise DeployError(f"the board has {self.disk:.0f} MB of disk left; free {disk} MB")
        if self.memory < memory:
            raise DeployError(f"the board has {self.memory:.0f} MB of memory left; free {memory:.0f} MB")
        if abs(self.clock) > CLOCK:
            raise DeployError(f"the board's clock is {self.clock:+.0f} s off; set it, e.g. timedatectl set-ntp true")
        return Target(self.machine, self.pythons[0])

    def __str__(self) -> str:
        known = ("asimddp", "i8mm", "avx2", "avx512_vnni")
        fast = ", ".join(name for name in known if name in self.features) or "no int8 features"
        room = f"{self.memory:.0f} MB memory, {self.disk:.0f} MB disk free"
        return f"{self.machine}, Python {'/'.join(self.pythons)}, {fast}, {room}"


class Board:
    """One destination of ssh, such as user@board."""

    def __init__(self, destination: str, ssh: str = SSH, root: str = ""):
        """``ssh``: the command with its options. ``root``: a folder on the board to install below, "" for /."""
        if not re.fullmatch(r"[^\s-]\S*", destination):
            raise DeployError(f"{destination!r} is no destination; write user@board")
        self.destination, self.root = destination, root
        try:
            self._command = [*shlex.split(ssh), destination]
        except ValueError as error:
            raise DeployError(f"--ssh {ssh!r} is no command ({error})") from None

    def probe(self) -> Facts:
        """Raises DeployError when it cannot be reached."""
        lines = self.run(_PROBE).splitlines()
        values = dict(line.split(" ", 1) for line in lines if " " in line)
        features = next((line.split()[1:] for line in lines if line.startswith("features")), [])
        versions = dict.fromkeys(re.findall(r"^Python (\d+\.\d+)", "\n".join(lines), re.MULTILINE))

        def numbers(name):
            return [float(line.split(" ")[1]) for line in lines if line.startswith(f"{name} ")]

        try:
            return Facts(
                machine=values["machine"],
                bits=int(values.get("bits", 0)),
                libc=tuple(int(part) for part in values.get("libc", "0.0").split(".")[:2]),
                installed="installed" in values,
                root=bool(self.root) or "root" in values,
                pythons=tuple(version for version in versions if version in PYTHONS),
                disk=min(numbers("disk")),
                memory=float(values["memory"]) + sum(numbers("robot")),
                features=frozenset(features),
                clock=float(values["clock"]) - time.time(),
            )
        except (KeyError, ValueError) as error:
            raise DeployError(f"{self.destination} does not tell what it is ({error}); is it a Linux?") from error

    def send(self, content: dict[str, bytes]) -> tuple[int, int]:
        """Make the board's copy of a bundle these files; how many were sent, and their bytes. Raises DeployError."""
        listed = self.run(f"mkdir -p {FOLDER} && cd {FOLDER} && find . -type f -exec sha256sum {{}} +")
        pairs = (line.split("  ./", 1) for line in listed.splitlines())
        there = {name: digest for digest, name in pairs}
        changed = {n: data for n, data in content.items() if there.get(n) != hashlib.sha256(data).hexdigest()}
        gone = sorted(there.keys() - content.keys())
        if gone:
            self.run(f"cd {FOLDER} && rm -f -- {shlex.join(gone)}")
        if changed:
            with subprocess.Popen([*self._command, f"cd {FOLDER} && tar xf -"], stdin=subprocess.PIPE) as process:
                try:
                    pack(changed, ".", process.stdin)
                except BrokenPipeError:
                    pass  # it says below why it ended
                finally:
                    process.stdin.close()
            if process.returncode:
                raise DeployError("the bundle could not be sent; see above")
        return len(changed), sum(map(len, changed.values()))

    def install(self) -> str:
        """What the bundle's own script says. Raises DeployError with its words when it fails."""
        return self.run(self._script(f"{FOLDER}/install.sh"))

    def rollback(self) -> str:
        """To the version before. Raises DeployError when there is none."""
        script = f"{shlex.quote(self.root)}/opt/vlpg/current/install.sh"
        return self.run(
            f"[ -e {script} ] || {{ echo there is no robot installed >&2; exit 1; }}; {self._script(script)} --rollback"
        )

    def doctor(self) -> tuple[str, bool]:
        """The table of the installed ``vlpg-doctor``, but for the link, and whether all is well."""
        memory = "" if self.root else f"$([ ! -e {STORE} ] || echo --memory {STORE})"
        done = self._run(f"{self._sudo}{shlex.quote(self.root)}/opt/vlpg/bin/vlpg-doctor --no-link {memory}")
        return done.stdout + done.stderr, done.returncode == 0

    def logs(self, follow: bool = False) -> int:
        """What the robot wrote last, in this terminal; an exit code."""
        return self.attach(f"{self._sudo}journalctl --unit vlpg-robot --lines 100 --no-pager {'--follow' * follow}")

    def bench(self, recording: Path, arguments: list[str]) -> tuple[int, Callable[[], str]]:
        """Run the installed ``vlpg-bench`` on a recording, in this terminal.

        Its exit code, and a function that fetches what it found, as JSON. Raises DeployError while the robot runs, and
        when the recording cannot be sent; one that is there already is not sent again.
        """
        state = "" if self.root else self.run("systemctl is-active vlpg-robot || true").strip()
        if state in ("active", "activating"):
            raise DeployError("the robot runs there and takes its share; first: sudo systemctl stop vlpg-robot")
        there, report = f"{MEASURED}/{recording.name}", f"{MEASURED}/report.json"
        known = self.run(f"mkdir -p {MEASURED}; rm -f {report}; sha256sum {shlex.quote(there)} 2>/dev/null || true")
        if known.split(" ")[0] != sha256(recording):
            quoted = shlex.quote(there)
            with recording.open("rb") as file:
                sent = subprocess.run([*self._command, f"cat > {quoted}.part && mv {quoted}.part {quoted}"], stdin=file)
            if sent.returncode:
                raise DeployError("the recording could not be sent; see above")
        command = [*arguments, "--recording", there, "--json", report]
        code = self.attach(f"{shlex.quote(self.root)}/opt/vlpg/bin/vlpg-bench {shlex.join(command)}")
        return code, lambda: self.run(f"cat {report}")

    def release(self) -> str:
        """The installed version, "" without one."""
        return self.run(f"readlink {shlex.quote(self.root)}/opt/vlpg/current || true").strip().removeprefix("releases/")

    def run(self, script: str) -> str:
        """What a shell script prints there. Raises DeployError with its last words when it fails."""
        done = self._run(script)
        if done.returncode:
            said = done.stderr.strip().splitlines() or done.stdout.strip().splitlines() or ["it says nothing"]
            raise DeployError(f"{self.destination}: {said[-1]}")
        return done.stdout

    def attach(self, command: str) -> int:
        """Run something there that writes to this terminal; its exit code."""
        return subprocess.call([*self._command, command])

    def _script(self, path: str) -> str:
        return f"{self._sudo}sh {path}{f' --root {shlex.quote(self.root)}' if self.root else ''}"

    @property
    def _sudo(self) -> str:
        return "" if self.root else 'sudo=; [ "$(id -u)" = 0 ] || sudo=sudo; $sudo '

    def _run(self, script: str) -> subprocess.CompletedProcess:
        return subprocess.run([*self._command, script], capture_output=True, text=True, stdin=subprocess.DEVNULL)
