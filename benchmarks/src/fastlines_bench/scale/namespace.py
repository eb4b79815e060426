"""A network namespace with a link to this machine, which can be cut."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import Any


class Namespace:
    """A namespace of its own for a worker; needs root, and the command ``ip``."""

    def __init__(self) -> None:
        # A process that is killed leaves its link behind, so each has addresses of its own.
        subnet = f"10.213.{os.getpid() % 256}"
        self.host, self.guest = f"{subnet}.1", f"{subnet}.2"
        self.name = f"fastlines{os.getpid()}"
        self.link, self.far = f"fl{os.getpid()}a", f"fl{os.getpid()}b"

    @staticmethod
    def is_possible() -> bool:
        """Whether namespaces can be made."""
        if not hasattr(os, "geteuid") or os.geteuid() != 0 or shutil.which("ip") is None:
            return False
        name = f"fastlines{os.getpid()}try"
        made = subprocess.run(["ip", "netns", "add", name], capture_output=True, check=False)
        if made.returncode:
            return False
        subprocess.run(["ip", "netns", "del", name], capture_output=True, check=False)
        return True

    def __enter__(self) -> Namespace:
        self._ip("netns", "add", self.name)
        self._ip("link", "add", self.link, "type", "veth", "peer", "name", self.far)
        self._ip("link", "set", self.far, "netns", self.name)
        self._ip("addr", "add", f"{self.host}/24", "dev", self.link)
        self._ip("link", "set", self.link, "up")
        for command in (("addr", "add", f"{self.guest}/24", "dev", self.far), ("link", "set", self.far, "up")):
            self._ip("-n", self.name, *command)
        self._ip("-n", self.name, "link", "set", "lo", "up")
        return self

    def __exit__(self, *_: object) -> None:
        subprocess.run(["ip", "link", "del", self.link], capture_output=True, check=False)
        subprocess.run(["ip", "netns", "del", self.name], capture_output=True, check=False)

    def start_worker(self, scheduler: str) -> Any:
        """Start a Dask worker of one thread in the namespace."""
        command = ["ip", "netns", "exec", self.name, sys.executable, "-m", "distributed.cli.dask_worker", scheduler]
        command += ["--nthreads", "1", "--host", self.guest, "--no-dashboard", "--no-nanny"]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def cut(self) -> None:
        """Take the link down."""
        self._ip("link", "set", self.link, "down")

    @staticmethod
    def _ip(*command: str) -> None:
        subprocess.run(["ip", *command], check=True, capture_output=True)
