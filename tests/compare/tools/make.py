"""GNU Make."""

import subprocess

from toy import INPUTS, OUTPUTS, STAGES
from tools.base import Tool


class Make(Tool):
    name = "make"

    def ask_version(self):
        return subprocess.run(["make", "--version"], capture_output=True, text=True, check=True).stdout.split()[2]

    def command(self):
        return ["make"]

    def write(self, folder):
        rules = [f"{OUTPUTS[s]}: {' '.join(INPUTS[s])}\n\t{self.python()} {s}.py\n" for s in reversed(STAGES)]
        (folder / "Makefile").write_text("\n".join(rules))
