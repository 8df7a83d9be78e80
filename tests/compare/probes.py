"""The probes of the behaviour table on the toy pipeline: each does the thing and tells what happened.

A cell is `ideal`, or what happened instead. What ran is read from the log that the stages themselves write.
"""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import toy

ALL = ["gen", "mid", "fig"]
SLEEP = 1.5  # seconds that gen waits halfway, where a probe needs it to
STEP = 0.05  # seconds between an edit and its neighbours, so that file times differ


class Bench:
    """A folder with the toy pipeline for one tool, run once."""

    def __init__(self, tool, parent, fresh=False, prepare=None):
        self.tool = tool
        self.folder = Path(tempfile.mkdtemp(prefix=f"{tool.name}-", dir=parent))
        self.log = self.folder.parent / f"{self.folder.name}.log"
        self.settings = {}
        self.options = tool.cache_options if prepare else []
        toy.write(self.folder)
        tool.write(self.folder)
        if prepare:
            self.settings = prepare(self.folder)
        if not fresh:
            self.must_run()
            self.first = self.final()

    def start(self, keep_log=False, **settings):
        """Starts the tool in a process group of its own."""
        if not keep_log:
            self.log.write_text("")
        environment = dict(os.environ, TOY_LOG=str(self.log), NO_COLOR="1", **self.settings, **settings)
        environment["PATH"] = f"{self.tool.bin}{os.pathsep}{environment['PATH']}"
        return subprocess.Popen(
            [*self.tool.command(), *self.options],
            cwd=self.folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def run(self, **settings):
        """Runs the tool: exit code, what it said."""
        time.sleep(STEP)
        process = self.start(**settings)
        said, _ = process.communicate()
        time.sleep(STEP)
        return process.returncode, said

    def must_run(self, **settings):
        code, said = self.run(**settings)
        if code != 0:
            raise RuntimeError(f"{self.tool.name} failed where it must not: {said[-2000:]}")
        return self.ran()

    def ran(self):
        """The stages that ran since the last start, in order of the pipeline, with how often if more than once."""
        lines = self.log.read_text().split()
        counts = [(stage, lines.count(stage)) for stage in ALL if stage in lines]
        return [stage if count == 1 else f"{stage} x{count}" for stage, count in counts]

    def final(self):
        return self.path("fig").read_bytes() if self.path("fig").exists() else None

    def path(self, stage):
        return self.folder / toy.OUTPUTS[stage]

    def edit(self, name, old, new):
        time.sleep(STEP)
        file = self.folder / name
        text = file.read_text()
        if old not in text:
            raise RuntimeError(f"{name} has no {old!r}")
        file.write_text(text.replace(old, new))

    def wait_for_gen(self):
        """Waits until gen is halfway."""
        deadline = time.time() + 60
        while time.time() < deadline:
            if "gen" in self.log.read_text() and self.path("gen").exists() and self.path("gen").stat().st_size > 0:
                time.sleep(0.2)
                return
            time.sleep(0.01)
        raise RuntimeError("gen did not start")


def flip(file, keep_times):
    """Flips one bit in the middle of a file; its size stays, its times and mode too if asked."""
    before = file.stat()
    os.chmod(file, 0o644)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    with open(file, "r+b") as out:
        out.write(data)
    if keep_times:
        os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
        os.chmod(file, before.st_mode)


def told(ran, ideal):
    """`ideal`, or what ran."""
    if ran == ideal:
        return "ideal"
    return "all 3" if ran == ALL else ", ".join(ran) or "nothing"


def stops(said):
    """What a tool that stopped said, in a few words."""
    wants = [flag for flag in ("--rerun-incomplete", "--unlock", "--force") if flag in said]
    return f"stops, wants `{wants[0]}`" if wants else "stops"


def bit_flip(tool, parent):
    bench = Bench(tool, parent)
    good = bench.path("gen").read_bytes()
    flip(bench.path("gen"), keep_times=True)
    bench.must_run()
    return "ideal" if bench.path("gen").read_bytes() == good else "unseen"


def cache_flip(tool, parent):
    share = getattr(tool, "share_cache", None)
    bench = Bench(tool, parent, prepare=share)
    good = bench.path("gen").read_bytes()
    cached = tool.cached(bench.folder, "gen")
    if cached is None:
        return "-"
    mode = cached.stat().st_mode & 0o777
    flip(cached, keep_times=True)
    for stage in ALL:
        bench.path(stage).unlink()
    code, said = bench.run()
    if code != 0:
        return stops(said)
    if bench.path("gen").read_bytes() == good:
        return "ideal"
    return f"served (file mode {mode:o}{', shared cache' if share else ''})"


def imported_edit(tool, parent):
    bench = Bench(tool, parent)
    bench.edit("helper.py", "3 * x", "5 * x")
    return told(bench.must_run(), ALL)


def comment_edit(tool, parent):
    bench = Bench(tool, parent)
    bench.edit(tool.source, "# Numbers from a parameter.", "# Numbers made from one parameter.")
    return told(bench.must_run(), [])


def early_cutoff(tool, parent):
    bench = Bench(tool, parent)
    bench.edit("params.txt", "first", "other")
    return told(bench.must_run(), ["gen", "mid"])


def revert(tool, parent):
    bench = Bench(tool, parent)
    bench.edit("params.txt", "7", "8")
    bench.must_run()
    bench.edit("params.txt", "8", "7")
    ran = bench.must_run()
    return told(ran, []) if bench.final() == bench.first else "wrong result"


def touch(tool, parent):
    bench = Bench(tool, parent)
    time.sleep(STEP)
    for name in ["params.txt", "helper.py", *(["gen.py"] if tool.source == "gen.py" else [tool.source])]:
        (bench.folder / name).touch()
    return told(bench.must_run(), [])


def intermediate_deleted(tool, parent):
    bench = Bench(tool, parent)
    bench.path("mid").unlink()
    return told(bench.must_run(), [])


def edit_during_run(tool, parent):
    bench = Bench(tool, parent, fresh=True)
    process = bench.start(TOY_SLEEP=str(SLEEP))
    bench.wait_for_gen()
    (bench.folder / "params.txt").write_text("8 second\n")
    process.communicate()
    return told(bench.must_run(), ALL)


def kill_in_gen(tool, parent):
    reference = Bench(tool, parent).first
    bench = Bench(tool, parent, fresh=True)
    process = bench.start(TOY_SLEEP="30")
    bench.wait_for_gen()
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    kill_strays(bench)
    code, said = bench.run()
    if code != 0:
        return stops(said)
    return "ideal" if bench.final() == reference else "torn file used"


def kill_strays(bench):
    """Ends stages that run in groups of their own: those whose work folder is this bench's."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").resolve() == bench.folder.resolve():
                os.kill(int(process.name), signal.SIGKILL)
        except OSError:
            continue


def disk_full(tool, parent):
    reference = Bench(tool, parent).first
    bench = Bench(tool, parent, fresh=True)
    mount = mount_small(bench.folder / "out", 64)
    if mount:
        return mount
    try:
        filler = bench.folder / "out/filler"
        filler.write_bytes(b"x" * (32 << 10))
        bench.run()
        filler.unlink()
        subprocess.run(["mount", "-o", "remount,size=1m", bench.folder / "out"], check=True)
        code, said = bench.run()
        if code != 0:
            return stops(said)
        return "ideal" if bench.final() == reference else "torn file used"
    finally:
        subprocess.run(["umount", "-l", bench.folder / "out"], check=True)


def mount_small(folder, kibibytes):
    """Mounts a small file system; why not, if it cannot be done."""
    command = ["mount", "-t", "tmpfs", "-o", f"size={kibibytes}k", "tmpfs", str(folder)]
    done = shutil.which("mount") and subprocess.run(command, capture_output=True)
    return None if done and done.returncode == 0 else "skipped (no mount)"


def two_at_once(tool, parent):
    bench = Bench(tool, parent, fresh=True)
    first = bench.start(TOY_SLEEP=str(SLEEP))
    second = bench.start(keep_log=True, TOY_SLEEP=str(SLEEP))
    codes = [process.communicate() and process.returncode for process in (first, second)]
    if codes != [0, 0]:
        return {(0, 1): "second fails", (1, 0): "first fails"}.get(tuple(min(abs(c), 1) for c in codes), "both fail")
    ran = bench.ran()
    return "ideal" if ran == ALL else f"both succeed: {', '.join(ran)}"


def hand_edit(tool, parent):
    bench = Bench(tool, parent)
    bench.edit("out/fig.svg", "<text>", "<text fill='red'>")
    code, said = bench.run()
    if code != 0:
        return stops(said)
    return "ideal" if bench.final() == bench.first else "kept"


def nondeterministic(tool, parent):
    bench = Bench(tool, parent, fresh=True)
    bench.must_run(TOY_DICE="1")
    first = bench.path("gen").read_bytes()
    bench.path("gen").unlink()
    for cache in (".doit.db", ".redun", ".dvc/cache", ".dvc/tmp"):
        if (bench.folder / cache).is_dir():
            shutil.rmtree(bench.folder / cache)
    bench.edit("params.txt", "first", "first ")
    code, said = bench.run(TOY_DICE="1")
    words = ("reproducib", "determinis", "differs from")
    if code != 0 or any(word in said.lower() for word in words):
        return "ideal"
    return "silent" if bench.path("gen").read_bytes() != first else "not made again"


# (row of the table, the ideal, its probe)
PROBES = [
    ("bit flip, mtime and size restored: detect, heal", bit_flip),
    ("bit flip of a cache object, work file gone: detect, heal", cache_flip),
    ("imported function edited: all users rerun", imported_edit),
    ("comment edited: nothing reruns", comment_edit),
    ("early cutoff, mid comes out equal: gen, mid", early_cutoff),
    ("revert: nothing reruns", revert),
    ("touch: nothing reruns", touch),
    ("intermediate deleted: nothing reruns", intermediate_deleted),
    ("input edited during the run: the next run redoes all", edit_during_run),
    ("kill -9 in gen: recovers, no action needed", kill_in_gen),
    ("disk full, then space: recovers", disk_full),
    ("two runs at once: share the work, both succeed", two_at_once),
    ("SVG edited by hand: detect, restore", hand_edit),
    ("nondeterministic stage: reported", nondeterministic),
]
