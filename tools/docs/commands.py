#!/usr/bin/env python3
"""Runs the commands that README and docs/ show, each page in a separate temporary folder. Prints TAP and figures.

  commands.py --list             every command with its page, line, class and exit code
  commands.py                    run those that take seconds; look at the others (a part of `make test`)
  commands.py --all              run those that take minutes, too (a part of `make test-lab`)
  commands.py --only docs/rig.md one page
  commands.py --tsv FILE         write the figures into FILE, one `name<TAB>value<TAB>unit<TAB>context` a line

A line of an indented or fenced block is a command if it begins with `make`, a program of build/bin, a script of this
repository or a tool from Debian. If a command's line ends with `\\`, the next line continues the command. If lines of a
block begin with `$`, only these lines are commands, and the other lines show the output of the commands.

A marker (an HTML comment) above the block states facts about the commands that this program cannot find out itself.
Without it, a command has the class `short`, or `make` when it begins with this word:

  <!-- command: CLASS[; exit N][; only TEXT][; with A=B C=D][; adding WORDS] -->

The key `only` limits a marker to the lines of the block that contain TEXT; a block may have several such markers. The
key `exit` is the expected exit code of the command. The key `with` replaces placeholders, such as names of
the reader's own files, before the command runs. The key `adding` gives words that the program appends to the command,
such as options for a smaller picture.
"""

import argparse
import collections
import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "check"))
import made_scenes  # noqa: E402
import sessions  # noqa: E402
from command_blocks import CLASSES, MarkError, commands  # noqa: E402

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))

SPAN = re.compile(r"```.*?```|`([^`]+)`", re.DOTALL)
MAKE = re.compile(r"make (?:[A-Z_0-9]+=\S+ )*([a-z][a-z0-9-]*)(?=\s|$)")
SLOW = ("lab", "anatomy")
SECONDS_SHORT, SECONDS_LONG, SECONDS_WINDOW = 300, 7200, 8


def pages():
    return ["README.md"] + sorted(
        "docs/" + name for name in os.listdir(os.path.join(ROOT, "docs")) if name.endswith(".md")
    )


# --- what a command names --------------------------------------------------------------------------------------------


def option_faults(words, known):
    """Yields an error for each long option of the command that the text `known` does not contain."""
    for word in words:
        option = re.match(r"--[a-z][a-z0-9-]*", word)
        if option and not re.search(re.escape(option.group(0)) + r"(?![a-z0-9-])", known):
            yield "no option %s" % option.group(0)


def program_of(words):
    """Returns the position of the first word of a command that names one of this project's programs, or None if there
    is no such word."""
    for at, word in enumerate(words):
        if re.match(r"((build/bin|tools|hil_tests)/)[\w./-]+$", word) or (
            at == 0 and word in ("cournand", "bake", "anatomy", "centreline")
        ):
            return at
    return None


def sources_text():
    """Returns the text of all source files. The text of all source files also contains the options of programs that are
    not built here."""
    listed = subprocess.run(
        ["git", "ls-files", "*.cpp", "*.hpp", "*.c", "*.h", "*.py", "*.sh"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    texts = []
    for path in listed.stdout.split("\n")[:-1]:
        if path != os.path.relpath(__file__, ROOT) and os.path.exists(os.path.join(ROOT, path)):
            with open(os.path.join(ROOT, path), encoding="utf-8", errors="replace") as file:
                texts.append(file.read())
    return "\n".join(texts)


def help_text(program, words):
    """Runs `PROGRAM SUBCOMMAND... --help` and returns its output."""
    subcommands = []
    for word in words:
        if not re.fullmatch(r"[a-z][a-z-]*", word) or len(subcommands) == 2:
            break
        subcommands.append(word)
    text = ""
    for count in range(len(subcommands) + 1):
        done = subprocess.run(
            [program] + subcommands[:count] + ["--help"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=60,
            check=False,
        )
        text += done.stdout
    return text


class Looker:
    """Checks a command without running it: the program and the options that the command names must exist."""

    def __init__(self, build):
        self.build = build
        self.sources = None

    def faults(self, command):
        found, words = [], []
        for word in shlex.split(command.text, comments=True) + ["&&"]:
            if word in ("&&", "||", "|", ";", "&"):
                found += self.faults_of(words)
                words = []
            else:
                words.append(word)
        return found

    def faults_of(self, words):
        at = program_of(words)
        if at is None:
            return []
        name, rest = words[at], words[at + 1 :]
        path = self.path(name)
        if path.endswith((".py", ".sh")) and not os.path.exists(path):
            return ["no file %s" % name]
        if path.startswith(os.path.join(ROOT, self.build)) and os.access(path, os.X_OK):
            known = help_text(path, rest)
        else:
            known = self.all_sources()
        return list(option_faults([word for word in rest if word.startswith("--")], known))

    def path(self, name):
        if "/" not in name:
            name = "build/bin/" + name
        return os.path.join(ROOT, re.sub(r"^build/", self.build + "/", name))

    def all_sources(self):
        if self.sources is None:
            self.sources = sources_text()
        return self.sources


def make_faults(text):
    """Checks a `make` command by a dry run (`make -n`)."""
    words = shlex.split(text, comments=True)
    done = subprocess.run(
        words[:1] + ["-n", "PACKAGES=skip"] + words[1:],
        cwd=ROOT,
        env=clean_environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    return (
        []
        if done.returncode == 0
        else ["its dry run ended with %d: %s" % (done.returncode, done.stderr.strip()[-400:])]
    )


def make_targets():
    """Returns every target of the Makefile."""
    done = subprocess.run(
        ["make", "-pnq", "PACKAGES=skip", "help"],
        cwd=ROOT,
        env=clean_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        check=False,
    )
    return set(re.findall(r"^([a-z][a-z0-9-]*):", done.stdout, re.M))


def inline_faults(page, text, targets):
    """Finds every `make TARGET` in the sentences of a document for which the Makefile has no such target."""
    for span in SPAN.finditer(text):
        make = MAKE.match(span.group(1) or "")
        if make and make.group(1) not in targets:
            yield "%s:%d: `make %s`, which is no target" % (page, line_of(text, span), make.group(1))


def line_of(text, match):
    return text.count("\n", 0, match.start()) + 1


def clean_environment():
    kept = {
        key: value
        for key, value in os.environ.items()
        if key not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "DISPLAY", "WAYLAND_DISPLAY")
    }
    return dict(kept, PACKAGES="skip")


# --- running ---------------------------------------------------------------------------------------------------------


class Scratch:
    """Makes a temporary folder that looks like the repository. The temporary folder contains links to the repository's
    files, a folder build/ with the programs, and a folder out/ with the demo's scene."""

    def __init__(self, build, stock):
        self.top = tempfile.mkdtemp(prefix="cournand_commands_")
        self.folder = os.path.join(self.top, "cournand")
        for name in ("build", "out", "tmp"):
            os.makedirs(os.path.join(self.folder, name))
        listed = subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True
        ).stdout
        for name in sorted({path.split("/")[0] for path in listed.split("\n") if path}):
            self.link(os.path.join(ROOT, name), name)
        for name in sorted(os.listdir(os.path.join(ROOT, build))):
            if name not in ("anatomy", "obj"):
                self.link(os.path.join(ROOT, build, name), "build/" + name)
        shutil.copytree(stock.out, os.path.join(self.folder, "out"), dirs_exist_ok=True)
        demo = os.path.join(stock.out, "demo.rec")
        if os.path.exists(demo):
            kept = os.path.join(self.folder, "state", "cournand")  # as the window keeps its recordings
            os.makedirs(kept)
            shutil.copy(demo, os.path.join(kept, "2026-01-31_10-15-00.rec"))
        if os.path.isdir(stock.anatomy):
            shutil.copytree(stock.anatomy, os.path.join(self.folder, "build", "anatomy"))
        beside = os.path.join(ROOT, "..", "shared")
        if os.path.isdir(beside):
            os.symlink(os.path.realpath(beside), os.path.join(self.top, "shared"))

    def link(self, source, name):
        if os.path.lexists(source) and not os.path.lexists(os.path.join(self.folder, name)):
            os.symlink(source, os.path.join(self.folder, name))

    def environment(self):
        here = dict(
            clean_environment(),
            TMPDIR=os.path.join(self.folder, "tmp"),
            XDG_STATE_HOME=os.path.join(self.folder, "state"),
        )
        here["PATH"] = os.path.join(self.folder, "build/bin") + os.pathsep + here["PATH"]
        return here

    def remove(self):
        shutil.rmtree(self.top, ignore_errors=True)


class Stock:
    """Makes the files that the commands of all pages need. The needed files are the content of out/ after
    `make run`, the folder build/anatomy and, for the run with --all, an artery with a lesion. The anatomy has no bodies
    (bones, organs), because making them takes minutes and no command of the short run needs them."""

    def __init__(self, build, folder):
        self.build, self.folder = build, folder
        self.out, self.anatomy = os.path.join(folder, "out"), os.path.join(folder, "anatomy")
        os.makedirs(self.out)

    def call(self, program, *words):
        done = subprocess.run(
            [os.path.join(ROOT, self.build, "bin", program)] + list(words),
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            text = " ".join([program] + list(words))
            raise RuntimeError("'%s' ended with %d: %s" % (text, done.returncode, done.stdout[-600:]))

    def scene(self, anatomy, name, lesion=None, bodies=False):
        """Makes the given anatomy and its scene, and returns the scene's path."""
        made, scene = os.path.join(self.anatomy, anatomy), os.path.join(self.out, name + ".scene")
        self.call("anatomy", anatomy, *([] if bodies else ["--no-bodies"]), "--quiet", "-o", made)
        text = os.path.join(made, "scene.toml")
        if lesion:
            with open(text, "a", encoding="utf-8") as file:
                file.write(made_scenes.lesion_text(lesion))
        self.call("bake", text, "--points", "1000", "--poses", "0", "-o", scene)
        return scene

    def record(self, scene, session, tools, name, *words):
        tools = [word for tool in tools for word in ("--tool", "shared/examples/instruments/%s.toml" % tool)]
        session = "shared/examples/sessions/%s.session" % session
        recording = os.path.join(self.out, name + ".rec")
        self.call(
            "cournand", "run", "--quiet", "--scene", scene, *tools, "--session", session, "--record", recording, *words
        )

    def make_short(self, bodies=False):
        if bodies:
            scene = self.scene("aorta", "aorta", bodies=True)
        else:
            scene = sessions.unpack_shipped(self.out)
            self.call("anatomy", "aorta", "--no-bodies", "--quiet", "-o", os.path.join(self.anatomy, "aorta"))
        self.record(scene, "demo", ["j_wire"], "demo")

    def make_long(self):
        scene = self.scene("heart", "lad_pci", "lad_middle")
        tools = ["j_wire", "coronary_014", "balloon_3x20", "guide_jl3_6f"]
        stent = "shared/examples/stents/coronary_3_0x18.toml"
        self.record(scene, "pci_lad", tools, "pci", "--stent", stent)


def prepared(command):
    """Returns the text that is executed for a command, after the replacements and additions of its marker."""
    text = re.sub(r"^sudo ", "", command.text)
    for name, value in command.words_with:
        text = re.sub(r"(?<![\w./-])%s(?![\w-])" % re.escape(name), value, text)
    if command.words_added:
        text = re.sub(r"(\s+#.*)?$", " " + command.words_added, text, count=1)
    return text


class Display:
    """Represents a virtual display, which the program starts when a command first opens a window."""

    def __init__(self):
        self.server = self.name = None

    def environment(self):
        if not self.server:
            words = ["Xvfb", "-displayfd", "1", "-screen", "0", "1280x1024x24", "-nolisten", "tcp", "-noreset"]
            self.server = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            self.name = ":" + self.server.stdout.readline().strip()
        return {"DISPLAY": self.name}

    def close(self):
        if self.server:
            self.server.terminate()
            self.server.wait()


def execute(command, scratch, display):
    """Runs a command and returns a text about its error; the text is empty if the command succeeded as expected."""
    is_window = command.kind == "display"
    words = ["bash", "-uo", "pipefail", "-c", ("exec " if is_window else "") + prepared(command)]
    environment = scratch.environment()
    if is_window:
        environment.update(display.environment())
        words = ["timeout", "-s", "INT", str(SECONDS_WINDOW)] + words
    limit_s = SECONDS_LONG if command.kind in SLOW else SECONDS_SHORT
    with open(os.path.join(scratch.folder, "tmp", "said"), "w+", encoding="utf-8", errors="replace") as said:
        files = {"stdin": subprocess.DEVNULL, "stdout": said, "stderr": said}
        process = subprocess.Popen(words, cwd=scratch.folder, env=environment, start_new_session=True, **files)
        try:
            code = process.wait(timeout=limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            code = "more than %d s" % limit_s
        said.seek(0)
        lines = said.read().splitlines()[-16:]
    wanted = 124 if is_window else command.exit  # 124: the command was still running at its time limit
    return [] if code == wanted else ["ended with %s, expected %s" % (code, wanted)] + lines


def processor_s():
    """Returns the processor time of all commands so far."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def missing_for(command):
    """Returns the reason why a command of the given class cannot run on this machine; returns an empty text if the
    command can run."""
    if command.kind == "anatomy" and not os.path.isdir(os.path.join(ROOT, "..", "shared", "anatomy")):
        return CLASSES["anatomy"][1]
    return ""


class Run:
    """Runs all commands of some pages, prints the results as TAP, and counts them."""

    def __init__(self, build, how):
        self.build, self.how = build, how
        self.number = self.failed = self.executed = 0
        self.by_kind = collections.Counter()
        self.looker = Looker(build)
        self.display = Display()
        self.dry = {}

    def result(self, name, faults, skip=""):
        self.number += 1
        self.failed += bool(faults)
        print("%s %d - %s%s" % ("not ok" if faults else "ok", self.number, name, " # SKIP " + skip if skip else ""))
        for line in faults:
            print("# " + line.replace("\n", "\n# "))
        sys.stdout.flush()

    def page(self, found, stock):
        if not found:
            return
        scratch = Scratch(self.build, stock)
        try:
            for command in found:
                self.command(command, scratch)
        finally:
            scratch.remove()

    def command(self, command, scratch):
        name = "%s:%d: %s" % (command.page, command.line, re.sub(r"\s+#.*", "", command.text)[:100].replace("#", "%"))
        self.by_kind[command.kind] += 1
        if command.kind == "make":
            words = re.sub(r"\s+#.*", "", command.text)
            if words not in self.dry:
                self.dry[words] = make_faults(words)
            self.executed += 1
            return self.result(name + " (dry run)", self.dry[words])
        if self.how in CLASSES[command.kind][0]:
            missing = missing_for(command)
            if not missing:
                begin = processor_s()
                self.executed += 1
                faults = execute(command, scratch, self.display)
                return self.result("%s (%.1f s)" % (name, processor_s() - begin), faults)
            return self.result(name, [], missing)
        return self.result("%s (looked at: %s)" % (name, CLASSES[command.kind][1]), self.looker.faults(command))

    def figures(self, total):
        kinds = " ".join("%s=%d" % one for one in sorted(self.by_kind.items()))
        context = "run=%s %s" % (self.how, kinds)
        return [
            ("docs.commands", total, "commands", context),
            ("docs.commands_run", self.executed, "commands", context),
            ("docs.commands_failed", self.failed, "commands", context),
            ("docs.commands_cpu_s", round(processor_s(), 1), "s", context),
        ]


def print_list(found):
    for one in found:
        print("%s:%d\t%s\texit %d\t%s" % (one.page, one.line, one.kind, one.exit, one.text))


def run_all(found, texts, options):
    run = Run(options.build, "all" if options.all else "short")
    targets = make_targets()
    run.result(
        "every `make TARGET` in a sentence is a target",
        [f for page, text in texts.items() for f in inline_faults(page, text, targets)],
    )
    with tempfile.TemporaryDirectory(prefix="cournand_stock_") as folder:
        stock = Stock(options.build, folder)
        wanted = " ".join(prepared(one) for one in found if run.how in CLASSES[one.kind][0])
        if re.search(r"out/(aorta|demo)|replay last|build/anatomy/aorta|real_patient|hil --aorta", wanted):
            stock.make_short(bodies="real_patient" in wanted)
        if re.search(r"out/(lad_pci|pci)\.", wanted):
            stock.make_long()
        for page in texts:
            run.page([one for one in found if one.page == page], stock)
    run.display.close()
    print("1..%d" % run.number)
    lines = ["\t".join(str(field) for field in one) for one in run.figures(len(found))]
    print("".join("#- %s\n" % line for line in lines), end="")
    if options.tsv:
        with open(options.tsv, "w", encoding="utf-8") as file:
            file.write("".join(line + "\n" for line in lines))
    return 1 if run.failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.environ.get("BUILD", "build"), help="build folder (default: build)")
    parser.add_argument("--all", action="store_true", help="run what takes minutes, too")
    parser.add_argument("--list", action="store_true", help="only list them")
    parser.add_argument("--only", metavar="PAGE", help="one page")
    parser.add_argument("--tsv", metavar="FILE", help="write the figures there")
    options = parser.parse_args()
    texts = {}
    for page in [options.only] if options.only else pages():
        with open(os.path.join(ROOT, page), encoding="utf-8") as file:
            texts[page] = file.read()
    try:
        found = [one for page, text in texts.items() for one in commands(page, text)]
        if options.list:
            print_list(found)
            return 0
        return run_all(found, texts, options)
    except (MarkError, RuntimeError, OSError) as error:
        print("Bail out! commands: %s" % error)
        return 2


if __name__ == "__main__":
    sys.exit(main())
