"""Provides the functions that all checks of the source tree use, to list the files, to extract the code from a file,
and to print TAP lines. Only test scripts import this module."""

import os
import re
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
C_SUFFIXES = (".c", ".h", ".cpp", ".hpp")


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8", errors="replace") as file:
        return file.read()


def files(*suffixes):
    """Returns a sorted list of the repository's files with the given endings. The list of files has the tracked files,
    and the untracked files that git does not ignore."""
    listed = (
        subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=ROOT, check=True, stdout=subprocess.PIPE
        )
        .stdout.decode()
        .split("\0")
    )
    return sorted({p for p in listed if p and p.endswith(suffixes) and os.path.isfile(os.path.join(ROOT, p))})


def blank(match):
    """Replaces each character of a comment or literal by a blank and keeps the line ends, so that line numbers do not
    change."""
    text = match.group(0)
    inside = re.sub(r"[^\n]", " ", text)
    return text[0] + inside[1:-1] + text[-1] if text[0] in "\"'" and len(text) > 1 else inside


TOKENS = re.compile(
    r'//(?:\\\n|[^\n])*|/\*.*?\*/|R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'', re.S
)


def code_only(text):
    """Returns the C or C++ text after replacing comments, the contents of literals, and preprocessor lines by
    blanks."""
    text = TOKENS.sub(blank, text)
    return re.sub(r"^[ \t]*#(?:\\\n|[^\n])*", blank_all, text, flags=re.M)


def blank_all(match):
    return re.sub(r"[^\n]", " ", match.group(0))


def line_of(text, position):
    return text.count("\n", 0, position) + 1


SCOPE = re.compile(r"^\s*(?:inline\s+)?(?:namespace|extern|class|struct|union|enum|template)\b")
AFTER_PARAMETERS = re.compile(r"[)}]\s*(?:const|noexcept|override|final|mutable|&|->\s*[\w:<>,*&\s]+|\s)*$")


def is_function_header(header):
    # `=` outside parentheses is an initialiser; the parameter list must be closed.
    outside = re.sub(r"\([^()]*\)", "()", re.sub(r"\([^()]*\)", "()", header))
    if "(" not in outside or re.search(r"(?<!operator)(?<![=!<>])=(?!=)", outside):
        return False
    return AFTER_PARAMETERS.search(outside) is not None


def functions(text):
    """Yields (name, first line, last line, body) of every function that is defined outside another function; `text`
    must come from code_only."""
    found = []
    scopes = []  # per open brace: "scope", ("function", header start, name) or "other"
    header_start = 0
    for match in re.finditer(r"[{};]", text):
        inside = any(kind != "scope" for kind in scopes)
        char, at = match.group(0), match.start()
        if char == ";":
            if not inside:
                header_start = at + 1
        elif char == "{":
            header = text[header_start:at]
            if inside:
                scopes.append("other")
            elif is_function_header(header):
                name = re.search(r"([~\w]+)\s*(?:<[^()]*>)?\s*\(", header)
                start = header_start + len(header) - len(header.lstrip())
                scopes.append(("function", start, name.group(1) if name else "?", at))
            elif SCOPE.match(header) and "=" not in header:
                scopes.append("scope")
                header_start = at + 1
            else:
                scopes.append("other")
        elif scopes:
            kind = scopes.pop()
            if isinstance(kind, tuple):
                found.append((kind[2], line_of(text, kind[1]), line_of(text, at), text[kind[3] : at + 1]))
            if kind != "other" and not any(k != "scope" for k in scopes):
                header_start = at + 1
    return found


class Report:
    """Prints one TAP line per rule, followed by the rule's findings."""

    def __init__(self):
        self.count = 0
        self.failed = 0

    def check(self, name, findings):
        """Reports one test as passed when the list `findings` is empty."""
        self.count += 1
        findings = list(findings)
        print("%s %d - %s" % ("not ok" if findings else "ok", self.count, name))
        for finding in findings:
            print("# " + finding.replace("\n", "\n# "))
        self.failed += bool(findings)

    def catches(self, name, findings):
        """Tests a rule of style itself: the test passes if the rule has found the fault in a bad sample."""
        findings = list(findings)
        self.check(name, [] if findings else ["the rule accepted the bad sample"])

    def accepts(self, name, findings):
        self.check(name, ["the rule objects to a good sample: " + f for f in findings])

    def end(self):
        print("1..%d" % self.count)
        sys.exit(1 if self.failed else 0)
