"""Snakemake. Its cache between workflows is no default: the probe of a cache object alone switches it on."""

from toy import INPUTS, OUTPUTS, STAGES
from tools.base import Tool


class Snakemake(Tool):
    name = "Snakemake"
    cache_options = ["--cache"]

    def command(self):
        return [self.bin / "snakemake", "--cores", "2"]

    def write(self, folder):
        rules = [f"rule all:\n    input: {OUTPUTS['fig']!r}\n"]
        for s in STAGES:
            inputs = ", ".join(map(repr, INPUTS[s]))
            shell = f"{self.python()} {s}.py"
            rules.append(f"rule {s}:\n    input: {inputs}\n    output: {OUTPUTS[s]!r}\n    shell: {shell!r}\n")
        (folder / "Snakefile").write_text("\n\n".join(rules))

    def share_cache(self, folder):
        """Switches the cache between workflows on; gives the environment it needs."""
        file = folder / "Snakefile"
        text = file.read_text()
        file.write_text(text.replace("    shell:", "    cache: 'omit-software'\n    shell:"))
        cache = folder.parent / f"{folder.name}-cache"
        cache.mkdir()
        return {"SNAKEMAKE_OUTPUT_CACHE": str(cache)}

    def cached(self, folder, stage):
        cache = folder.parent / f"{folder.name}-cache"
        wanted = (folder / OUTPUTS[stage]).read_bytes()
        return next((f for f in cache.rglob("*") if f.is_file() and f.read_bytes() == wanted), None)
