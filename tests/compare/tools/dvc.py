"""DVC, without git."""

import hashlib
import subprocess

from toy import INPUTS, OUTPUTS, STAGES
from tools.base import Tool


class Dvc(Tool):
    name = "DVC"

    def command(self):
        return [self.bin / "dvc", "repro"]

    def write(self, folder):
        subprocess.run([self.bin / "dvc", "init", "--no-scm", "--quiet"], cwd=folder, check=True, capture_output=True)
        lines = ["stages:"]
        for s in STAGES:
            lines += [f"  {s}:", f"    cmd: {self.python()} {s}.py", "    deps:"]
            lines += [f"    - {name}" for name in INPUTS[s]]
            lines += ["    outs:", f"    - {OUTPUTS[s]}"]
        (folder / "dvc.yaml").write_text("\n".join(lines) + "\n")

    def cached(self, folder, stage):
        name = hashlib.md5((folder / OUTPUTS[stage]).read_bytes()).hexdigest()
        return folder / ".dvc/cache/files/md5" / name[:2] / name[2:]
