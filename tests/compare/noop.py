"""The time of a run with nothing to do, process start to exit: the least of several, in milliseconds.

The graph of the other tools: one file copied by all tasks but one, which reads all copies. Ours: the tiny paper with so
many realisations that it has as many pieces, each with its key, record and object.
"""

import json
import os
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARY = ROOT / "target/release/encounter"
SIZES = [201, 1001, 5001]
SMALL = {"doit", "Snakemake", "DVC", "redun"}  # at the smallest size alone: the others would take hours to set up


def graph(tool, folder, tasks):
    """Writes the graph for one tool."""
    (folder / "out").mkdir(parents=True)
    (folder / "in.txt").write_text("1\n")
    names = [f"out/{i}.txt" for i in range(tasks - 1)]
    everything = " ".join(names)
    if tool == "make":
        rules = "out/%.txt: in.txt\n\tcp in.txt $@\n"
        text = f"all.txt: {everything}\n\ttouch all.txt\n\n{rules}"
        (folder / "Makefile").write_text(text)
    elif tool == "ninja":
        lines = ["rule copy", "  command = cp in.txt $out", "rule end", "  command = touch $out"]
        lines += [f"build {name}: copy in.txt" for name in names] + [f"build all.txt: end {everything}"]
        (folder / "build.ninja").write_text("\n".join(lines) + "\n")
    elif tool == "doit":
        (folder / "dodo.py").write_text(
            f"NAMES = [f'out/{{i}}.txt' for i in range({tasks - 1})]\n\n\n"
            "def task_copy():\n    for name in NAMES:\n"
            "        yield {'name': name, 'actions': [f'cp in.txt {name}'], 'file_dep': ['in.txt'], 'targets': [name]}\n\n\n"
            "def task_end():\n    return {'actions': ['touch all.txt'], 'file_dep': NAMES, 'targets': ['all.txt']}\n"
        )
    elif tool == "Snakemake":
        (folder / "Snakefile").write_text(
            f"rule end:\n    input: expand('out/{{i}}.txt', i=range({tasks - 1}))\n    output: 'all.txt'\n"
            "    shell: 'touch {output}'\n\n"
            "rule copy:\n    input: 'in.txt'\n    output: 'out/{i}.txt'\n    shell: 'cp {input} {output}'\n"
        )
    elif tool == "DVC":
        lines = ["stages:"]
        for i, name in enumerate(names):
            lines += [f"  copy{i}:", f"    cmd: cp in.txt {name}", "    deps: [in.txt]", f"    outs: [{name}]"]
        deps = "".join(f"\n    - {name}" for name in names)
        lines += ["  end:", "    cmd: touch all.txt", f"    deps:{deps}", "    outs: [all.txt]"]
        (folder / "dvc.yaml").write_text("\n".join(lines) + "\n")
    elif tool == "redun":
        (folder / "workflow.py").write_text(
            "import shutil\n\nfrom redun import File, task\n\nredun_namespace = 'noop'\n\n\n"
            "@task()\ndef copy(source: File, i: int) -> File:\n"
            "    shutil.copy(source.path, f'out/{i}.txt')\n    return File(f'out/{i}.txt')\n\n\n"
            "@task()\ndef end(copies: list) -> int:\n    return len(copies)\n\n\n"
            f"@task()\ndef main() -> int:\n    return end([copy(File('in.txt'), i) for i in range({tasks - 1})])\n"
        )


def least(command, folder, times):
    """The least time of some runs that must succeed, milliseconds."""
    best = float("inf")
    for _ in range(times):
        start = time.perf_counter()
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        best = min(best, time.perf_counter() - start)
    return f"{best * 1e3:.1f}" if best < 0.1 else f"{best * 1e3:,.0f}"


def of_tool(tool, parent):
    """One row: a cell per size."""
    cells = []
    for tasks in SIZES:
        if tool.name in SMALL and tasks != SIZES[0]:
            cells.append("-")
            continue
        folder = parent / f"noop-{tool.name}-{tasks}"
        graph(tool.name, folder, tasks)
        if tool.name == "DVC":
            subprocess.run([tool.bin / "dvc", "init", "--no-scm", "--quiet"], cwd=folder, check=True)
        os.environ["PATH"] = f"{tool.bin}{os.pathsep}{os.environ['PATH']}"
        least(tool.command(), folder, 1)
        cells.append(least(tool.command(), folder, 3 if tool.name in SMALL else 60))
    return cells


def ours(store, profile, *settings):
    """Pieces, and the least time of `run` and `status` with nothing to do."""
    options = ["--profile", profile, "--store", str(store), *settings]
    command = [BINARY, "run", *options]
    # The second run finds files older than the clock's grain and takes note of them.
    for _ in range(2):
        subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
        time.sleep(2.1)
    said = json.loads(subprocess.run([*command, "--json"], cwd=ROOT, check=True, capture_output=True).stdout)
    if said["ran"]:
        raise RuntimeError(f"{len(said['ran'])} pieces ran where nothing was to do")
    return said["reused"], least(command, ROOT, 60), least([BINARY, "status", *options], ROOT, 60)


def of_ours(parent):
    """Rows of ours: label, cells."""
    # Pieces that stay, and pieces of one realisation, from the tiny paper itself.
    one, two = (dry(parent, n) for n in (1, 2))
    run_cells, status_cells = [], []
    for tasks in SIZES:
        realisations = -(-(tasks - one) // (two - one)) + 1
        found = ours(parent / f"noop-{tasks}", "tiny", "--set", f"vhgp_seq.realisations={realisations}")
        run_cells.append(f"{found[1]} ({found[0]:,} keys)")
        status_cells.append(found[2])
    quick = ours(parent / "noop-quick", "quick")
    quick_line = f"The quick profile, {quick[0]} keys: `encounter run` {quick[1]} ms, `encounter status` {quick[2]} ms."
    return [("encounter run", run_cells), ("encounter status", status_cells)], quick_line


def dry(parent, realisations):
    """The number of pieces of the tiny paper."""
    settings = ["--set", f"vhgp_seq.realisations={realisations}", "--store", str(parent / "none"), "--json"]
    command = [BINARY, "status", "--profile", "tiny", *settings]
    nodes = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)["nodes"]
    return sum(node["pieces"] for node in nodes)
