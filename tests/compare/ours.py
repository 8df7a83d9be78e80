"""Our own row: the same probes on the real binary, built from a copy of this repository whose sources may be edited.

gen, mid and fig are three stages of the paper: ground_truth -> response_moments -> Figure 4, all for the first ship. The
profile is tiny; every probe has a store of its own. A code edit is an edit of the copy and a real `cargo build` of it.
"""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from probes import flip, mount_small, told

ROOT = Path(__file__).resolve().parents[2]
HOME = ROOT / "target/compare"
COPY = HOME / "copy"
BUILT = HOME / "debug/encounter"
BASE = HOME / "encounter"  # the binary of the unedited copy
PROFILE = ["--profile", "tiny"]
NODES = {
    "gen": "ground_truth/calibrated-S1",
    "mid": "response_moments/calibrated-S1",
    "fig": "fig4_response_moments/calibrated-S1",
}
FIGURES = "figures/tiny"
FIGURE = f"{FIGURES}/fig4_response_moments.svg"
PARAMETERS = "stages/paper.toml"
GEN_SOURCE = "stages/ground_truth.rs"
IMPORTED = "src/ship/roll_equation.rs"


def copy_sources():
    """Lays this work tree's files, edits included, over the copy; files that are equal keep their times."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=ROOT, check=True, capture_output=True
    )
    names = [name for name in listed.stdout.decode().split("\0") if name and (ROOT / name).is_file()]
    for name in names:
        target = COPY / name
        data = (ROOT / name).read_bytes()
        if not target.is_file() or target.read_bytes() != data:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
    for old in [*COPY.glob("src/**/*.rs"), *COPY.glob("stages/**/*")]:
        if old.is_file() and str(old.relative_to(COPY)) not in names:
            old.unlink()


def build():
    """Builds the copy in its own target folder."""
    environment = dict(os.environ, CARGO_TARGET_DIR=str(HOME))
    command = ["cargo", "build", "--quiet", "--bin", "encounter"]
    said = subprocess.run(command, cwd=COPY, env=environment, capture_output=True, text=True)
    if said.returncode != 0:
        raise RuntimeError(f"cargo build: {said.stderr[-2000:]}")


class Edited:
    """An edit of a file of the copy, built if it is code; taken back at the end."""

    binary = BASE

    def __init__(self, name, old, new, compiled=True):
        self.file, self.old, self.new, self.compiled = COPY / name, old, new, compiled

    def __enter__(self):
        self.text = self.file.read_text()
        if self.old not in self.text:
            raise RuntimeError(f"{self.file.name} has no {self.old!r}")
        self.file.write_text(self.text.replace(self.old, self.new, 1))
        if self.compiled:
            build()
            Edited.binary = BUILT

    def __exit__(self, *_):
        self.file.write_text(self.text)
        Edited.binary = BASE


class Encounter:
    """The tool whose column this is."""

    name = "encounter"

    def missing(self):
        """Why it cannot be used here; None if it can."""
        if shutil.which("cargo") is None:
            return "cargo not found"
        copy_sources()
        build()
        shutil.copy(BUILT, BASE)
        said = subprocess.run([BASE, "--version"], capture_output=True, text=True, check=True)
        self.version = said.stdout.split()[1]
        return None


class Bench:
    """A store with the figures in it, run once."""

    template = None

    def __init__(self, parent, fresh=False):
        self.store = Path(tempfile.mkdtemp(prefix="store-", dir=parent)) / "store"
        if fresh:
            return
        if Bench.template is None:
            Bench.template = Path(parent) / "template"
            self.store, own = Bench.template, self.store
            self.must_run()
            self.store = own
        shutil.copytree(Bench.template, self.store)

    def start(self, *arguments):
        """Starts the binary in a process group of its own."""
        figures = str(self.store / FIGURES)
        command = [Edited.binary, *arguments, *PROFILE, "--store", str(self.store), "--figures", figures]
        pipe = subprocess.PIPE
        return subprocess.Popen(command, cwd=COPY, stdout=pipe, stderr=pipe, text=True, start_new_session=True)

    def call(self, *arguments):
        """Exit code, standard output, standard error."""
        process = self.start(*arguments)
        out, err = process.communicate()
        return process.returncode, out, err

    def run(self):
        code, out, err = self.call("run", "--json")
        return code, json.loads(out) if out.strip() else {}, err

    def must_run(self):
        code, said, err = self.run()
        if code != 0:
            raise RuntimeError(f"failed where it must not, exit code {code}: {err[-2000:]}")
        return said

    def object(self, stage):
        """The file of a node's output."""
        code, out, err = self.call("show", NODES[stage], "--json")
        if code != 0:
            raise RuntimeError(err)
        name = json.loads(out)["id"]
        return self.store / "objects" / name[:2] / name[2:]

    def lock(self):
        """What a run publishes, by name and hash."""
        return sorted((file["path"], file["id"]) for file in self.must_run()["files"])

    def figure(self):
        return self.store / FIGURE


def stages(said):
    """The probe's stages among those that ran."""
    ran = {piece["node"] for piece in said["ran"]}
    return [stage for stage, node in NODES.items() if node in ran]


def healed(said):
    return [stage for stage, node in NODES.items() if any(line.startswith(node) for line in said["healed"])]


def bit_flip(_, parent):
    bench = Bench(parent)
    damaged = [bench.figure(), bench.object("gen")]
    good = [file.read_bytes() for file in damaged]
    bench.must_run()
    for file in damaged:
        flip(file, keep_times=True)
    bench.must_run()
    same = [file.exists() and file.read_bytes() == was for file, was in zip(damaged, good)]
    return {(True, True): "ideal", (True, False): "figure healed, object unseen"}.get(tuple(same), "unseen")


def cache_flip(_, parent):
    bench = Bench(parent)
    damaged = [bench.object(stage) for stage in NODES]
    good = [file.read_bytes() for file in damaged]
    picture = bench.figure().read_bytes()
    bench.must_run()
    for file in damaged:
        flip(file, keep_times=True)
    shutil.rmtree(bench.store / "figures")
    said = bench.must_run()
    if bench.figure().read_bytes() != picture:
        return "served"
    unseen = [s for s, file, was in zip(NODES, damaged, good) if not file.exists() or file.read_bytes() != was]
    return f"figure right, unseen in {', '.join(unseen)}" if unseen else "ideal" if said["healed"] else "healed in silence"


def imported_edit(_, parent):
    bench = Bench(parent)
    with Edited(IMPORTED, "let restoring = (forcing.stiffness[i] +", "let restoring = (forcing.stiffness[i] * 1.001 +"):
        return told(stages(bench.must_run()), ["gen", "mid", "fig"])


def comment_edit(_, parent):
    bench = Bench(parent)
    with Edited(GEN_SOURCE, "        let samples =", "        // Samples of a field.\n        let samples ="):
        said = bench.must_run()
        return told(stages(said), []) if not said["ran"] or stages(said) else f"{len(said['ran'])} pieces elsewhere"


def early_cutoff(_, parent):
    bench = Bench(parent)
    with Edited(PARAMETERS, "temporal_level = 0.25", "temporal_level = 0.3", compiled=False):
        return told(stages(bench.must_run()), ["gen", "mid"])


def revert(_, parent):
    bench = Bench(parent)
    first = bench.lock()
    with Edited(PARAMETERS, "temporal_level = 0.25", "temporal_level = 0.3", compiled=False):
        bench.must_run()
    said = bench.must_run()
    return "wrong result" if bench.lock() != first else "ideal" if not said["ran"] else told(stages(said), ["?"])


def touch(_, parent):
    bench = Bench(parent)
    time.sleep(0.05)
    for name in (PARAMETERS, GEN_SOURCE, IMPORTED):
        (COPY / name).touch()
    build()
    Edited.binary = BUILT
    said = bench.must_run()
    Edited.binary = BASE
    return "ideal" if not said["ran"] else told(stages(said), ["?"])


def intermediate_deleted(_, parent):
    bench = Bench(parent)
    bench.must_run()
    bench.object("mid").unlink()
    said = bench.must_run()
    if not said["ran"] and not said["healed"]:
        return "ideal"
    by_hand = told(stages(said) or healed(said), [])
    bench = Bench(parent)
    # Garbage collection is how intermediates are deleted here.
    code, _, err = bench.call("gc", "--max", "0")
    if code != 0 or bench.object("mid").exists():
        return by_hand
    said = bench.must_run()
    return f"{by_hand}; taken by `gc`: {told(stages(said) or healed(said), ['?'])}"


def edit_during_run(_, parent):
    bench = Bench(parent, fresh=True)
    process = bench.start("run", "--json", "-j", "1")
    wait_for(bench, process, "objects")
    with Edited(PARAMETERS, "alpha_1 = 0.01                    # 1/s, as printed", "alpha_1 = 0.011", compiled=False):
        process.communicate()
        return told(stages(bench.must_run()), ["gen", "mid", "fig"])


def wait_for(bench, process, folder):
    """Waits until the run has written something into a folder of its store."""
    deadline = time.time() + 60
    while time.time() < deadline and process.poll() is None:
        if any(file.is_file() for file in (bench.store / folder).rglob("*")):
            return
        time.sleep(0.002)
    raise RuntimeError("the run ended before it could be disturbed")


def kill_in_gen(_, parent):
    reference = Bench(parent).lock()
    for times in range(3):
        bench = Bench(parent, fresh=True)
        process = bench.start("run", "-j", "2")
        wait_for(bench, process, "objects")
        time.sleep(0.3 * times)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        code, _, err = bench.run()
        if code != 0:
            return f"stops: {err.strip().splitlines()[-1][:60]}"
        if bench.lock() != reference or bench.call("verify", "--store")[0] not in (0, 2):
            return "wrong result"
    return "ideal"


def disk_full(_, parent):
    reference = Bench(parent)
    size = sum(file.stat().st_size for file in reference.store.rglob("*") if file.is_file())
    bench = Bench(parent, fresh=True)
    bench.store.mkdir()
    mount = mount_small(bench.store, max(size // 2048, 256))
    if mount:
        return mount
    try:
        code, _, err = bench.run()
        if code != 5:
            return f"exit code {code} on a full disk"
        subprocess.run(["mount", "-o", "remount,size=64m", bench.store], check=True)
        code, _, err = bench.run()
        if code != 0:
            return f"stops: {err.strip().splitlines()[-1][:60]}"
        return "ideal" if bench.lock() == reference.lock() else "wrong result"
    finally:
        subprocess.run(["umount", "-l", bench.store], check=True)


def two_at_once(_, parent):
    reference = Bench(parent)
    pieces = len(json.loads(reference.call("status", "--json")[1])["nodes"])
    bench = Bench(parent, fresh=True)
    both = [bench.start("run", "--json", "-j", "1") for _ in range(2)]
    said = [process.communicate()[0] for process in both]
    codes = [process.returncode for process in both]
    if codes != [0, 0]:
        return {(0, 1): "second fails", (1, 0): "first fails"}.get(tuple(min(c, 1) for c in codes), "both fail")
    ran = [(piece["node"], piece["piece"]) for text in said for piece in json.loads(text)["ran"]]
    twice = len(ran) - len(set(ran))
    if bench.lock() != reference.lock() or len(set(ran)) < pieces:
        return "wrong result"
    return "ideal" if twice == 0 else f"both succeed, {twice} of {len(set(ran))} pieces run twice"


def hand_edit(_, parent):
    bench = Bench(parent)
    good = bench.figure().read_bytes()
    bench.figure().write_bytes(good.replace(b"<svg", b"<svg class='mine'", 1))
    files = json.loads(bench.call("status", "--json")[1])["files"]
    state = next(file["state"] for file in files if FIGURE.endswith("/" + file["path"]))
    bench.must_run()
    if bench.figure().read_bytes() != good:
        return "kept"
    return "ideal" if state == "edited" else f"restored, status says {state}"


def nondeterministic(_, parent):
    bench = Bench(parent, fresh=True)
    now = "std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |t| t.as_secs_f64())"
    moved = f"epsilon_1: p.ship.epsilon_1.iter().map(|e| e + 1e-15 * {now}).collect(),"
    with Edited(GEN_SOURCE, "epsilon_1: p.ship.epsilon_1.clone(),", moved):
        bench.must_run()
        code, out, err = bench.call("verify", "--rebuild")
        if code in (3, 4) and "ground_truth/" in out + err:
            return "ideal"
        return "silent" if code == 0 else f"exit code {code}, the stage not named"


PROBES = [
    bit_flip,
    cache_flip,
    imported_edit,
    comment_edit,
    early_cutoff,
    revert,
    touch,
    intermediate_deleted,
    edit_during_run,
    kill_in_gen,
    disk_full,
    two_at_once,
    hand_edit,
    nondeterministic,
]

# Those that build the copy anew, which takes longest, come last.
SLOW = {imported_edit, comment_edit, touch, nondeterministic}
