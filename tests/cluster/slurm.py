"""A Slurm of its own in a folder: munged, slurmctld and two virtual nodes, n1 and n2, on this machine."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

from sweep import run, skip, wait_until

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")

CONFIGURATION = """\
ClusterName=bench
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/log/slurmctld.log
SlurmdLogFile={folder}/log/slurmd.%n.log
SlurmctldPort={ports[0]}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=bf_interval=1,sched_min_interval=0
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
SlurmdTimeout=6
MessageTimeout=3
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 RealMemory=1000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 RealMemory=1000
PartitionName=bench Nodes=ALL Default=YES State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Slurm:
    def __init__(self, folder):
        os.environ["PATH"] += ":/usr/sbin:/sbin"
        missing = [program for program in PROGRAMS if shutil.which(program) is None]
        if missing:
            skip(f"needs {', '.join(missing)} (./setup --cluster)")
        if os.geteuid() != 0:
            skip("only root can start Slurm")
        self.folder = pathlib.Path(folder)

    def __enter__(self):
        folder = self.folder
        for name in ("state", "log", "spool.n1", "spool.n2"):
            (folder / name).mkdir(parents=True)
        folder.chmod(0o755)
        (folder / "slurm.conf").write_text(CONFIGURATION.format(
            folder=folder, ports=free_ports(3), host=socket.gethostname().split(".")[0]))
        (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
        try:
            run("munged", f"--key-file={key}", f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
                f"--log-file={folder}/log/munged.log", f"--seed-file={folder}/munged.seed")
            self._start("slurmctld")
            for node in ("n1", "n2"):
                self.start_node(node)
            wait_until(lambda: self.node_states() == {"n1": "idle", "n2": "idle"}, "both nodes")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process in self.processes():
            self._kill(process)
        for name in ("slurmd.n1", "slurmd.n2", "slurmctld", "munged"):
            self._stop(name)

    def _start(self, *words):
        # Daemons keep inherited files open: they must not get a pipe whose end somebody waits for.
        with open(self.folder / "log" / "start.log", "a", encoding="utf-8") as log:
            subprocess.run(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log, check=True)

    def start_node(self, node):
        processors = sorted(os.sched_getaffinity(0))
        processor = processors[0 if node == "n1" else -1]
        self._start("taskset", "-c", str(processor), "slurmd", "-N", node)

    def _pid(self, name):
        try:
            return int((self.folder / f"{name}.pid").read_text())
        except (OSError, ValueError):
            return None

    @staticmethod
    def _kill(pid, number=signal.SIGKILL):
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass

    def kill_together(self, pids):
        """Stops all of them first, so that none sees another end."""
        for number in (signal.SIGSTOP, signal.SIGKILL):
            for pid in pids:
                self._kill(pid, number)

    def _stop(self, name, number=signal.SIGTERM):
        pid = self._pid(name)
        if pid is None:
            return
        self._kill(pid, number)
        until = time.monotonic() + 10
        while time.monotonic() < until and pathlib.Path(f"/proc/{pid}").exists():
            time.sleep(0.02)
        self._kill(pid)

    def node_states(self):
        lines = subprocess.run(["sinfo", "-h", "-N", "-o", "%N %T"], capture_output=True, text=True, check=False).stdout
        return dict(line.split() for line in lines.splitlines())

    @staticmethod
    def is_daemon(pid):
        """Whether it is the daemon that waits for a job; false if it has ended."""
        try:
            return pathlib.Path(f"/proc/{pid}/comm").read_text(encoding="utf-8").startswith("slurmstepd")
        except OSError:
            return False

    def processes(self, node=None):
        """Of jobs of this Slurm, with the daemons that wait for them: by the environment that Slurm gives them."""
        ours = f"SLURM_CONF={self.folder}/slurm.conf".encode()
        found = set()
        for entry in pathlib.Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                environment = (entry / "environ").read_bytes().split(b"\0")
                if ours not in environment or not any(one.startswith(b"SLURM_JOB_ID=") for one in environment):
                    continue
                if node and f"SLURMD_NODENAME={node}".encode() not in environment:
                    continue
                found.add(int(entry.name))
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
                if self.is_daemon(parent):
                    found.add(parent)
            except (OSError, IndexError):
                continue
        return found

    def programs(self, node, program):
        """Those of them that are `program`."""
        return [pid for pid in self.processes(node) if os.path.realpath(f"/proc/{pid}/exe") == os.path.realpath(program)]

    def kill_node(self, node):
        """As if it lost power: its daemon, and all of its jobs."""
        self._stop(f"slurmd.{node}", signal.SIGKILL)

        def is_dead():
            left = self.processes(node)
            self.kill_together(left)
            return not left
        wait_until(is_dead, f"the end of {node}")

    def job(self, number):
        return run("scontrol", "-o", "show", "job", number).stdout

    def active(self):
        return run("squeue", "-h", "-r", "-o", "%i %T %R").stdout.splitlines()
