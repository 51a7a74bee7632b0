"""Reads the table of commands and options of the project's programs from the man pages that the programs write. Only
test scripts import this module."""

import collections
import os
import re
import subprocess
import tempfile

import tree

BIN = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"), "bin")
PROGRAMS = ("cournand", "anatomy", "bake", "centreline")

# words: the program and its command; below: the names of its subcommands; outputs: the options that name what the
# command writes; options: all of them.
Command = collections.namedtuple("Command", "words below outputs options")


def write_pages(program, folder):
    done = subprocess.run(
        [os.path.join(BIN, program), "--generate", "man", folder],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError("%s --generate man: %s" % (program, done.stdout))


def names(text):
    """Returns the longest name of each option that the text of a man page describes."""
    found = []
    for line in re.findall(r"^\.TP\n\.B (\\-.*)$", text, re.M):
        plain = line.replace("\\-", "-").split(" ")[0]
        found.append(plain.split(",")[-1])
    return found


def section(page, begin, end):
    match = re.search(r"^%s\n(.*?)(?=^%s|\Z)" % (begin, end), page, re.M | re.S)
    return match.group(1) if match else ""


def commands():
    """Returns the commands of all programs, a command before its subcommands."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for program in PROGRAMS:
            write_pages(program, folder)
        for name in sorted(os.listdir(folder)):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                page = file.read()
            words = re.search(r"^\.SH SYNOPSIS\n\.B (.*)$", page, re.M).group(1).replace("\\-", "-").split()
            below = re.findall(r"^\.B (\S+)\(1\)$", section(page, r"\.SH COMMANDS", r"\.SH"), re.M)
            below = [one.replace("\\-", "-")[len("-".join(words)) + 1 :] for one in below]
            outputs = names(section(page, r"\.SS Outputs", r"\.S[SH]"))
            found.append(Command(words, below, outputs, names(section(page, r"\.SH OPTIONS", r"\.SH"))))
    return found
