"""A tool: how its files are written, how it is called, where it caches."""

import subprocess
import sys


class Tool:
    """One build tool with its default settings."""

    name = ""
    source = "gen.py"  # the file that holds gen's code

    def __init__(self, bin_folder):
        self.bin = bin_folder

    def missing(self):
        """Why the tool cannot be used here; None if it can."""
        try:
            self.version = self.ask_version()
        except (OSError, subprocess.CalledProcessError, IndexError) as why:
            return str(why).splitlines()[0]
        return None

    def ask_version(self):
        said = subprocess.run(self.version_command(), capture_output=True, text=True, check=True)
        return (said.stdout + said.stderr).split("\n")[0].split()[-1].split(".git")[0]

    def version_command(self):
        return [*self.command()[:1], "--version"]

    def command(self):
        raise NotImplementedError

    def write(self, folder):
        raise NotImplementedError

    def cached(self, folder, stage):
        """The file in the tool's cache that holds a stage's output; None if it keeps no cache by default."""
        return None

    def python(self):
        return sys.executable
