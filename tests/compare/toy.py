"""The toy pipeline of every tool, gen -> mid -> fig: three scripts and a helper that two of them import.

params.txt -> gen.py -> out/gen.txt -> mid.py -> out/mid.txt -> fig.py -> out/fig.svg

Each script appends its name to the file $TOY_LOG, so what ran is counted where it runs, whatever the tool says. gen waits
$TOY_SLEEP seconds halfway through writing; with $TOY_DICE it writes something else each time.
"""

HELPER = '''\
def scale(x):
    return 3 * x
'''

GEN = '''\
import os
import time

from helper import scale


def gen():
    # Numbers from a parameter.
    note("gen")
    number, remark = open("params.txt").read().split()
    dice = time.time_ns() if "TOY_DICE" in os.environ else 0
    with open("out/gen.txt", "w") as out:
        out.write(f"# {remark}\\n")
        for i in range(8000):
            out.write(f"{scale(int(number) + i) + dice}\\n")
            if i == 4000:
                out.flush()
                time.sleep(float(os.environ.get("TOY_SLEEP", "0")))
'''

MID = '''\
import os

from helper import scale


def mid():
    # The sum of what gen wrote, remarks left out.
    note("mid")
    total = sum(scale(int(line)) for line in open("out/gen.txt") if not line.startswith("#"))
    with open("out/mid.txt", "w") as out:
        out.write(f"{total}\\n")
'''

FIG = '''\
import os


def fig():
    # A picture of the sum.
    note("fig")
    with open("out/fig.svg", "w") as out:
        out.write(f"<svg><text>{open('out/mid.txt').read().strip()}</text></svg>\\n")
'''

NOTE = '''\


def note(stage):
    with open(os.environ["TOY_LOG"], "a") as log:
        log.write(stage + "\\n")
'''

STAGES = ("gen", "mid", "fig")
SOURCES = dict(zip(STAGES, (GEN, MID, FIG)))
INPUTS = {
    "gen": ["gen.py", "params.txt"],
    "mid": ["mid.py", "out/gen.txt"],
    "fig": ["fig.py", "out/mid.txt"],
}
OUTPUTS = {"gen": "out/gen.txt", "mid": "out/mid.txt", "fig": "out/fig.svg"}


def write(folder):
    """Writes the scripts and the parameter; the tool's own file is written by the tool."""
    (folder / "out").mkdir()
    (folder / "helper.py").write_text(HELPER)
    (folder / "params.txt").write_text("7 first\n")
    for stage, source in SOURCES.items():
        (folder / f"{stage}.py").write_text(f"{source}{NOTE}\n\n{stage}()\n")
