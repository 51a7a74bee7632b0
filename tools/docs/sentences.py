#!/usr/bin/env python3
"""Prints a random sample of the sentences in README, documents and comments, for a reader who has never seen these
sentences.

  sentences.py --seed 7 --count 60
  sentences.py --seed 7 --count 20 --file docs/ --file host/xray    only files whose path begins so

The output has one line `NUMBER<TAB>FILE<TAB>SENTENCE` per sentence. If neither the seed nor the source tree has
changed, the program prints the same sample again. The reader marks every sentence that he or she has to read a second
time (docs/testing.md, "Plain English").
"""

import argparse
import os
import random
import re
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
WORDS_MIN = 6  # shorter ones are labels
ENDS = re.compile(r"(?<=[a-z0-9)`%\"'”])[.!?](?=\s+[A-Z`\"(]|\s*$)")
# Matches a comment of whole lines, and a comment after code, with its continuation far to the right.
COMMENT = re.compile(
    r"^[ \t]*//[^\n]*(?:\n[ \t]*//[^\n]*)*|(?<!:)//[^\n]*(?:\n[ \t]{20,}//[^\n]*)*|/\*.*?\*/", re.S | re.M
)
DOCSTRING = re.compile(r"^[ \t]*\"\"\".*?\"\"\"", re.S | re.M)  # and no other long string
GENERATED = re.compile(r"<!-- (?:begin|table of).*?<!-- end.*?-->", re.S)
NOTATION = re.compile(r"Format: |[{\[]")  # number formats and JSON are skipped like tables


def files(*patterns):
    listed = subprocess.run(
        ["git", "ls-files", "--"] + list(patterns), cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    return listed.split("\n")[:-1]


def split(text):
    """Splits a paragraph into sentences and returns the sentences."""
    begin, found = 0, []
    for end in ENDS.finditer(text):
        found.append(" ".join(text[begin : end.end()].split()))
        begin = end.end()
    return [one for one in found if len(one.split()) >= WORDS_MIN and not NOTATION.match(one)]


def of_document(text):
    """Yields the sentences in the paragraphs and list items of a document; code, tables, headings and pictures are left
    out."""
    text = re.sub(r"```.*?```|<!--.*?-->", "\n\n", GENERATED.sub("\n\n", text), flags=re.S)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    for paragraph in re.split(r"\n\s*\n|\n(?=- |\d+\. )", text):
        lines = [line for line in paragraph.split("\n") if not re.match(r"    |\||#|!", line)]
        yield from split(re.sub(r"^(- |\d+\. )", "", " ".join(lines)).replace("**", ""))


def of_source(text, comments=COMMENT):
    """Yields the sentences in the comments of a source file; indented examples in the comments are left out."""
    for comment in comments.findall(text):
        lines = [re.sub(r"^[ \t]*(///?|/\*+|\*/|\*)?|\*/$|\"\"\"", "", line) for line in comment.split("\n")]
        for paragraph in re.split(r"\n\s*\n", "\n".join(line for line in lines if not line.startswith("   "))):
            yield from split(paragraph)


def of_script(text):
    """Yields the sentences in the docstrings of a Python file."""
    return of_source(text, DOCSTRING)


def sentences(prefixes=("",)):
    """Returns (file, sentence) in order for all files whose path begins with one of the prefixes. Without prefixes,
    returns the sentences of all files."""
    found = []
    for path in files("*.md") + files("*.c", "*.h", "*.cpp", "*.hpp", "*.py"):
        if not path.startswith(tuple(prefixes)):
            continue
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            text = file.read()
        of_text = {".md": of_document, ".py": of_script}.get(os.path.splitext(path)[1], of_source)
        found += [(path, one) for one in of_text(text)]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--file", action="append", metavar="PREFIX", help="only files whose path begins so; repeatable")
    options = parser.parse_args()
    found = sentences(options.file or ("",))
    if not 1 <= options.count <= len(found):
        print("sentences: --count is 1 to %d" % len(found), file=sys.stderr)
        return 2
    for number, (path, sentence) in enumerate(random.Random(options.seed).sample(found, options.count), 1):
        print("%d\t%s\t%s" % (number, path, sentence))
    return 0


if __name__ == "__main__":
    sys.exit(main())
