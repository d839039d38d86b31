"""Most memory that this process has held, which a process that it begins does not inherit."""

from pathlib import Path


def peak_kib():
    """Peak of the resident memory since the program began [KiB] (proc(5), VmHWM)."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1])
    raise OSError("this kernel does not say VmHWM")
