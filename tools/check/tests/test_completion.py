#!/usr/bin/env python3
"""Tests the completion of command lines and the man pages in the way that a user meets them. Real shells (bash and zsh
on a terminal, fish) complete commands, options and names with the scripts that the programs write. The programs groff
and mandoc must give no warning about the man pages. Prints TAP.

Each test case has the beginning of a command line, and the text that the shell must make of it after the Tab key."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import command_table  # noqa: E402
import tree  # noqa: E402

LIMIT_S = 60
CASES = [
    ("a command", "cournand repl", "cournand replay"),
    ("a subcommand", "cournand rig self", "cournand rig selftest"),
    ("an option", "cournand run --mp", "cournand run --mp4"),
    ("an instrument", "cournand run demo --tool j_w", "cournand run demo --tool j_wire"),
    ("a second instrument", "cournand view --tool j_wire --tool pigt", "cournand view --tool j_wire --tool pigtail_5f"),
    ("an instrument behind =", "cournand run --tool=pigt", "cournand run --tool=pigtail_5f"),
    ("a stent", "cournand run --stent ren", "cournand run --stent renal_6_0x18"),
    ("a session", "cournand run over", "cournand run over_the_wire"),
    ("a scene", "cournand run demo --scene aor", "cournand run demo --scene aorta"),
    ("a recording", "cournand replay las", "cournand replay last"),
    ("a choice", "cournand run --style vc", "cournand run --style vcsim3"),
    ("a file", "cournand run --record unus", "cournand run --record unusual.rec"),
    ("a folder", "cournand run --dicom fold", "cournand run --dicom folder"),
    ("a command of another program", "centreline conv", "centreline convert"),
    ("an option of another program", "bake --surf", "bake --surface"),
    ("an anatomy", "anatomy phan", "anatomy phantom"),
]


class Home:
    """Makes an empty home folder, with the programs in PATH, and a current folder with one file, one folder and one
    recording."""

    def __init__(self, path):
        self.path = path
        self.here = os.path.join(path, "here")
        self.share = os.path.join(path, "share")
        os.makedirs(os.path.join(self.here, "folder"))
        os.makedirs(os.path.join(path, "cournand"))
        for name in ("here/unusual.rec", "cournand/2026-01-01_10-00-00.rec"):
            with open(os.path.join(path, name), "w", encoding="utf-8") as file:
                file.write("x")
        for program in command_table.PROGRAMS:
            done = subprocess.run(
                [os.path.join(command_table.BIN, program), "--generate", "share", self.share], check=False
            )
            if done.returncode != 0:
                raise RuntimeError("%s --generate share ended with %d" % (program, done.returncode))

    def environment(self):
        kept = {"PATH": command_table.BIN + os.pathsep + os.environ["PATH"], "HOME": self.path, "TERM": "dumb"}
        return dict(kept, XDG_STATE_HOME=self.path, XDG_CONFIG_HOME=self.path, LC_ALL="C.UTF-8", COLUMNS="200")

    def script(self, shell, program):
        places = {"bash": "bash-completion/completions/%s", "zsh": "zsh/site-functions/_%s"}
        places["fish"] = "fish/vendor_completions.d/%s.fish"
        return os.path.join(self.share, places[shell] % program)


class Terminal:
    """Runs an interactive shell on a pseudo-terminal."""

    def __init__(self, home, words, begin):
        self.process, self.file = pty.fork()
        if self.process == 0:
            os.chdir(home.here)
            os.execvpe(words[0], words, home.environment())
        self.text = ""
        self.send(begin + "\necho re''ady\n")
        self.wait("ready")

    def send(self, text):
        os.write(self.file, text.encode())

    def wait(self, wanted):
        """Reads the terminal's output until it contains the text `wanted`. Returns False if the text `wanted` does not
        appear."""
        while wanted not in self.text:
            if not select.select([self.file], [], [], LIMIT_S)[0]:
                return False
            try:
                piece = os.read(self.file, 65536)
            except OSError:
                return False
            # Without the terminal's orders: backspaces, bells, colours.
            self.text += re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]|\x1b[=>]|[\x07\r]", "", piece.decode(errors="replace"))
        return True

    def completed(self, line):
        """Returns the words of the line that the shell makes of `line` when the Tab key is pressed. After the Tab key,
        the test uses Ctrl-A and Ctrl-E to put a command that prints its arguments in front of the completed line."""
        self.text = ""
        self.send(line + '\t\x01printf \'<%s>\' \x05; echo "<e"nd"g>"\n')
        if not self.wait("<endg>"):
            return "nothing: " + self.text[-400:]
        found = re.findall(r"^((?:<[^<>\n]*>)+)<endg>", self.text, re.M)
        found = [words.replace("/>", ">") for words in found]  # a shell may remove the last slash of a folder again
        return found[-1] if found else "nothing: " + self.text[-400:]

    def close(self):
        os.close(self.file)
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)


def as_words(line):
    return "".join("<%s>" % word for word in line.split())


def terminal_faults(home, shell):
    scripts = [home.script(shell, program) for program in command_table.PROGRAMS]
    sources = "\n".join("source %s" % script for script in scripts)
    words, begin = {
        "bash": (["bash", "--norc", "--noprofile", "-i"], sources),
        "zsh": (
            ["zsh", "-f", "-i"],
            "unsetopt zle_bracketed_paste; autoload compinit; compinit -u; bindkey -e\n" + sources,
        ),
    }[shell]
    terminal = Terminal(home, words, begin)
    try:
        for name, line, wanted in CASES:
            found = terminal.completed(line)
            yield name, [] if found == as_words(wanted) else ["%s became %s" % (line, found)]
    finally:
        terminal.close()


def fish_faults(home, shell):
    for name, line, wanted in CASES:
        source = "source %s; complete -C '%s'" % (home.script(shell, line.split()[0]), line)
        done = subprocess.run(
            ["fish", "--no-config", "-c", source],
            cwd=home.here,
            env=home.environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        offered = [one.split("\t")[0].rstrip("/") for one in done.stdout.splitlines()]
        yield name, [] if offered == wanted.split()[-1:] else ["%s became %s" % (line, done.stdout)]


def check_shells(report, home):
    for shell, faults in (("bash", terminal_faults), ("zsh", terminal_faults), ("fish", fish_faults)):
        for name, found in faults(home, shell):
            report.check("%s completes %s" % (shell, name), found)


def check_pages(report, home):
    folder = os.path.join(home.share, "man", "man1")
    pages = sorted(os.listdir(folder))
    wanted = ["-".join(command.words) + ".1" for command in command_table.commands()]
    report.check("every program and every command has a man page", sorted(set(wanted) ^ set(pages)))
    for name, words in (("groff", ["man", "--warnings", "-l"]), ("mandoc", ["mandoc", "-T", "lint", "-W", "warning"])):
        found = []
        for page in pages:
            done = subprocess.run(
                words + [os.path.join(folder, page)],
                env=dict(os.environ, MANPAGER="cat", MANWIDTH="80", LC_ALL="C.UTF-8"),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                check=False,
            )
            said = done.stderr if name == "groff" else done.stdout + done.stderr
            if done.returncode != 0 or said:
                found.append("%s: exit %d, %s" % (page, done.returncode, said))
        report.check("%s formats every man page without a warning" % name, found)


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as path:
        home = Home(path)
        check_pages(report, home)
        check_shells(report, home)
    report.end()


if __name__ == "__main__":
    main()
