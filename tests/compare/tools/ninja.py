"""ninja."""

from toy import INPUTS, OUTPUTS, STAGES
from tools.base import Tool


class Ninja(Tool):
    name = "ninja"

    def command(self):
        return [self.bin / "ninja"]

    def write(self, folder):
        rules = [f"rule python\n  command = {self.python()} $script\n"]
        for s in STAGES:
            rules.append(f"build {OUTPUTS[s]}: python {' '.join(INPUTS[s])}\n  script = {s}.py\n")
        (folder / "build.ninja").write_text("\n".join(rules))
