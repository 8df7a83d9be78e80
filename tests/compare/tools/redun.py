"""redun: the stages are Python tasks in one workflow file."""

import subprocess

from toy import NOTE, OUTPUTS, SOURCES, STAGES
from tools.base import Tool


class Redun(Tool):
    name = "redun"
    source = "workflow.py"

    def ask_version(self):
        said = subprocess.run([self.bin / "redun", "--version"], capture_output=True, text=True, check=True)
        return (said.stdout + said.stderr).split("version")[-1].split()[0].strip()

    def command(self):
        return [self.bin / "redun", "run", "workflow.py", "main"]

    def write(self, folder):
        imports, tasks = set(), []
        for s in STAGES:
            head, body = SOURCES[s].split(f"def {s}():\n")
            imports |= {line for line in head.splitlines() if line}
            body = body.rstrip() + f"\n    return File({OUTPUTS[s]!r})\n"
            tasks.append(f"@task()\ndef {s}(source: File) -> File:\n{body}")
        main = "@task()\ndef main() -> File:\n    return fig(mid(gen(File('params.txt'))))\n"
        head = "\n".join(sorted(imports)) + "\n\nfrom redun import File, task\n\nredun_namespace = 'toy'\n"
        (folder / "workflow.py").write_text("\n\n".join([head, *tasks, main]) + NOTE)
