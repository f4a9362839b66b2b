"""Forks kernels of a process that has loaded what they load: fork_server.py MODULE ...

A line of stdin asks for a kernel, or whether one has ended; a line of stdout answers.
Where stdin ends the server ends, and the kernels that it made with it.
"""

import gc
import importlib
import json
import os
import sys

# What a kernel loads while it starts; it begins no thread and opens no socket.  The
# backend of matplotlib is left to the kernel, of which it asks what it draws for.
OF_A_KERNEL = (
    "IPython.core.completerlib",
    "IPython.extensions.storemagic",
    "ipykernel.debugger",
    "ipykernel.ipkernel",
    "ipykernel.kernelapp",
)


def load(names):
    """Load what there is; a kernel says itself what it misses."""
    for name in names:
        try:
            importlib.import_module(name)
        except Exception:
            pass


def rehearse():
    """Format an error once; kernels then have what is slow the first time.

    Where it fails they do that themselves, and take longer.
    """
    try:
        from IPython.core.ultratb import FormattedTB

        FormattedTB(mode="Context", tb_offset=0).text(*an_error())
    except Exception:
        pass


def an_error():
    """Class, error and traceback of one, with lines of Python to colour."""
    try:
        raise ValueError("not of a notebook")
    except ValueError:
        return sys.exc_info()


def serve():
    """Answer until stdin ends.  Gives in a new kernel what was asked, else nothing."""
    for line in sys.stdin:
        asked = json.loads(line)
        if "poll" in asked:
            ended, status = os.waitpid(asked["poll"], os.WNOHANG)
            answer = os.waitstatus_to_exitcode(status) if ended else None
        elif len(os.listdir("/proc/self/task")) > 1:
            answer = None  # a fork would leave threads behind, and the locks they hold
        elif not (answer := os.fork()):
            return asked
        print(json.dumps(answer), flush=True)
    return None


def become_a_kernel(arguments, cwd, env):
    """What a process of its own is: a group, a folder, an environment, no streams."""
    server = os.getppid()
    os.setsid()
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    os.close(nothing)
    sys.argv = ["ipykernel_launcher", *arguments]

    from ipykernel.kernelapp import IPKernelApp

    IPKernelApp.launch_instance(
        argv=[*arguments, f"--IPKernelApp.parent_handle={server}"]
    )


if __name__ == "__main__":
    del sys.path[0]  # the folder of this file; a kernel has its own in its place
    load([*OF_A_KERNEL, *sys.argv[1:]])
    rehearse()
    gc.freeze()  # kernels share what is loaded, as long as none touches it
    if kernel := serve():
        become_a_kernel(**kernel)
