"""doit."""

from toy import INPUTS, OUTPUTS, STAGES
from tools.base import Tool


class Doit(Tool):
    name = "doit"

    def command(self):
        return [self.bin / "doit"]

    def write(self, folder):
        tasks = []
        for s in STAGES:
            fields = {"actions": [f"{self.python()} {s}.py"], "file_dep": INPUTS[s], "targets": [OUTPUTS[s]]}
            tasks.append(f"def task_{s}():\n    return {fields!r}\n")
        (folder / "dodo.py").write_text("\n\n".join(tasks))
