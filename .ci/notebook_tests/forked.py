"""Kernels that start in a tenth of the time: each a fork of one process.

A kernel takes 2 s to load itself and the libraries of the notebooks.  A server does so
once, and each kernel begins as a copy of it, in which no cell was run.  Where there is
no such server a kernel is a process of its own.
"""

import atexit
import functools
import json
import os
import subprocess
import sys
from pathlib import Path

import nbval.kernel
from jupyter_client.manager import KernelManager
from jupyter_client.provisioning import LocalProvisioner

LAUNCHER = ["-m", "ipykernel_launcher"]


def use(*modules):
    """Let nbval fork its kernels of a process that has loaded these modules."""
    nbval.kernel.KernelManager = manager(KernelManager, modules)


@functools.cache
def manager(kind, modules):
    """A class of kernel managers of a `kind`, which forks where a fork is sound."""
    if sys.platform != "linux":  # elsewhere libraries do not survive a fork
        return kind

    class Manager(kind):
        def __init__(self, **options):
            super().__init__(**options)
            self.provisioner = Provisioner(kernel_spec=self.kernel_spec, parent=self)
            self.provisioner.modules = modules

    return Manager


class Provisioner(LocalProvisioner):
    modules = ()

    async def launch_kernel(self, cmd, **options):
        if cmd[1:3] == LAUNCHER:
            asked = {"arguments": cmd[3:], "env": options["env"]}
            cwd = os.path.abspath(options.get("cwd") or ".")
            try:
                self.process = server(cmd[0], self.modules).kernel(cwd=cwd, **asked)
            except (OSError, ValueError):
                pass
            else:
                self.pid = self.pgid = self.process.pid
                self.cwd = cwd
                return self.connection_info
        return await super().launch_kernel(cmd, **options)


@functools.cache
def server(python, modules):
    return Server(python, modules)


class Server:
    def __init__(self, python, modules):
        self.process = subprocess.Popen(
            [python, Path(__file__).with_name("fork_server.py"), *modules],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        atexit.register(self.close)

    def ask(self, **asked):
        self.process.stdin.write(json.dumps(asked) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def kernel(self, **asked):
        """A new kernel; OSError or ValueError where the server died or will not."""
        if pid := self.ask(**asked):
            return Kernel(self, pid)
        raise ValueError("the server has threads")

    def close(self):
        self.process.communicate()


class Kernel:
    """A forked process, with what jupyter_client asks of a `Popen`."""

    stdin = stdout = stderr = None

    def __init__(self, server, pid):
        self.server, self.pid, self.status = server, pid, None

    def poll(self):
        """Its exit status once it has ended, also where the server has."""
        if self.status is None:
            try:
                self.status = self.server.ask(poll=self.pid)
            except (OSError, ValueError):
                self.status = -1
        return self.status

    wait = poll  # jupyter_client waits for what has ended

    def send_signal(self, signum):
        if self.poll() is None:
            os.kill(self.pid, signum)
