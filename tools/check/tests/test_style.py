#!/usr/bin/env python3
"""Checks those rules of style that a program can check: lengths, banned words and calls, recursion, layout, documents,
packages and make targets. The test first shows that each rule finds the fault in a bad sample. Prints TAP."""
import ast
import os
import re
import subprocess
import tempfile

import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

FUNCTION_LINES_MAX = 70
FILE_LINES_MAX = 600
LINE_LETTERS_MAX = 120
# These files may have longer lines, for the stated reason. A row of a Markdown table may also be longer, because it
# cannot continue on another line.
LONG_LINES = {
    ".tsv": "a row is a line",
    ".csv": "a row is a line",
    ".json": "written by programs",
    ".golden": "written by a program",
    ".abi": "written by libabigail",
    ".rec": "a recording, which is no text",
    ".checked": "written by a program",
    ".corpus": "an input of a fuzzer in base64 is a line",
    ".toml": "a value with its source is one string",
    ".session": "a statement is a line, and pictures are stamped with the bytes of their session",
    ".xz": "no text",
    ".jpg": "no text",
    ".png": "no text",
}
DEVICE = ("firmware/core/", "firmware/app/", "shared/wire/", "shared/scene/")

# Word -> what to use instead. Device code is fixed-point, without heap and without libc.
BANNED = {
    "float": "fixed point (firmware/core/fixed.h)",
    "double": "fixed point (firmware/core/fixed.h)",
    "malloc": "memory of the caller",
    "calloc": "memory of the caller",
    "realloc": "memory of the caller",
    "free": "memory of the caller",
    "alloca": "an array with a named limit",
    "printf": "a typed code for the caller",
    "snprintf": "a typed code for the caller",
    "fprintf": "a typed code for the caller",
    "puts": "a typed code for the caller",
    "sqrt": "crn_sqrt64",
    "sin": "crn_sincos_turn32",
    "cos": "crn_sincos_turn32",
    "tan": "crn_sincos_turn32",
    "atan2": "crn_asin_q29",
    "asin": "crn_asin_q29",
    "acos": "crn_asin_q29",
    "pow": "a named product",
    "exp": "a table",
    "fabs": "an integer comparison",
    "rand": "a seeded generator in the tests",
    "setjmp": "a return code",
    "longjmp": "a return code",
    "goto": "a function",
    "abort": "a typed code for the caller",
    "exit": "a typed code for the caller",
    "assert": "a typed code for the caller",
}
CALLERS = re.compile("Called" " by: |May" " include: ")
UNFINISHED = re.compile(r"\b(%s)\b" % "|".join(["TO" "DO", "FIX" "ME", "XX" "X", "HA" "CK"]))


EARLIER_NAME = re.compile("s" "eld(?!om)", re.IGNORECASE)
PACKED = (".jpg", ".png", ".xz", ".rec", ".corpus")  # four letters in a row are chance here


# --- rules: each yields findings as file:line: text ----------------------------------------------------------------
def earlier_name(path, text):
    """Finds former names of the project in a path or in a line of text."""
    if EARLIER_NAME.search(path):
        yield path + ": has the project's earlier name"
    for number, line in enumerate(text.splitlines(), 1):
        if EARLIER_NAME.search(line):
            yield "%s:%d: has the project's earlier name" % (path, number)


def long_functions(path, text):
    for name, first, last, _ in functions_of(path, text):
        if last - first + 1 > FUNCTION_LINES_MAX:
            yield "%s:%d: %s has %d lines, at most %d: split it" % (path, first, name, last - first + 1,
                FUNCTION_LINES_MAX)


def functions_of(path, text):
    if path.endswith(".py"):
        return [(node.name, node.lineno, node.end_lineno, "") for node in ast.walk(ast.parse(text))
                if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]
    return tree.functions(tree.code_only(text))


def long_file(path, text):
    lines = text.count("\n")
    if lines > FILE_LINES_MAX:
        yield "%s: %d lines, at most %d: one file tells one story" % (path, lines, FILE_LINES_MAX)


def long_lines(path, text):
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LINE_LETTERS_MAX and not (path.endswith(".md") and line.startswith("|")):
            yield "%s:%d: %d letters, at most %d: wrap it" % (path, number, len(line), LINE_LETTERS_MAX)


def callers(path, text):
    """Finds comments that list the callers of a function or the permitted includes, because such a list would have to
    be kept up to date by hand."""
    for number, line in enumerate(text.splitlines(), 1):
        if CALLERS.search(line):
            yield "%s:%d: lists its callers or includes: leave that to a search, or to docs/architecture.md" % (
                path, number)


def unfinished(path, text):
    for match in UNFINISHED.finditer(text):
        yield "%s:%d: '%s' marks unfinished work: finish it or open an issue" % (path,
            tree.line_of(text, match.start()),
                                                                             match.group(1))


def banned_words(path, text):
    code = tree.code_only(text)
    # Bodies of macros are code too, so preprocessor lines are read apart (not #include, #error).
    defines = re.sub(r"^[ \t]*#[ \t]*(?:include|error|warning)[^\n]*", tree.blank_all,
                     tree.TOKENS.sub(tree.blank, text),
                     flags=re.M)
    for word, instead in BANNED.items():
        lines = {tree.line_of(t, m.start()) for t in (code, defines) for m in re.finditer(r"\b%s\b" % word, t)}
        for line in sorted(lines):
            yield "%s:%d: '%s' is banned on the device: use %s" % (path, line, word, instead)


# The host and the tools make text from numbers in one way, and read TOML in one way.
NUMBERS = re.compile(r"\b(?:v?sn?printf|to_chars|setprecision)\b|\bstd::fixed\b")
NUMBER_FILES = ("host/base/format.cpp", "host/base/number_text.cpp")
# The reader, one writer, and the program that compares the parser with another one.
TOML_FILES = ("host/base/toml.cpp", "host/base/toml_reader.cpp", "tools/lab/calibrate/fitted_instrument.cpp",
              "tools/importers/main.cpp")


def other_readers_and_numbers(path, text):
    if path not in NUMBER_FILES:
        for match in NUMBERS.finditer(tree.code_only(text)):
            yield "%s:%d: '%s': use host/base/number_text.hpp, or formatted() of host/base/format.hpp" % (
                path, tree.line_of(text, match.start()), match.group())
    if path not in TOML_FILES and '#include "host/base/toml.hpp"' in text:
        yield "%s: includes toml++: use host/base/toml_reader.hpp" % path


CAST = r"(?:\(+\s*(?:u?int\d+_t|unsigned|int|size_t)\s*\))?"
CONSTANT = CAST + r"\s*\(*\s*(?:\d\w*|[A-Z][A-Z0-9_]*(?:_[a-z]\w*)?\b|sizeof\b)"


def variable_division(path, text):
    """Finds a division or remainder whose divisor is not a literal, a named constant (CRN_...) or sizeof."""
    code = tree.code_only(text)
    for match in re.finditer(r"[/%]=?(?!=)", code):
        if not re.match(r"\s*" + CONSTANT, code[match.end() :]):
            yield "%s:%d: division by a variable: use crn_reciprocal_q30, or crn_divide_u64 in set-up code" % (
                path, tree.line_of(code, match.start()))


def call_graph(sources):
    """Reads sources (path -> text) and returns a table from each function's name to (place of its definition, names of
    the functions that it calls)."""
    defined = {}
    for path, text in sources.items():
        for name, first, _, body in tree.functions(tree.code_only(text)):
            key = name if name not in defined else path + ":" + name
            defined[key] = ("%s:%d" % (path, first), set(re.findall(r"\b(\w+)\s*\(", body)))
    return {name: (place, {c for c in calls if c in defined}) for name, (place, calls) in defined.items()}


def recursion(sources):
    left = call_graph(sources)
    while True:
        leaves = [name for name, (_, calls) in left.items() if not any(c in left for c in calls)]
        if not leaves:
            break
        for name in leaves:
            del left[name]
    for name, (place, calls) in sorted(left.items()):
        cycle = sorted(c for c in calls if c in left)
        yield "%s: %s calls %s, which leads back: no recursion on the device" % (place, name, ", ".join(cycle))


def layout(paths):
    """Checks with clang-format that every C and C++ file has the project's layout."""
    for start in range(0, len(paths), 50):
        done = subprocess.run(["clang-format", "--dry-run", "-Werror"] + paths[start : start + 50], cwd=tree.ROOT,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if done.returncode != 0:
            text = done.stdout.decode("utf-8", "replace")
            for path in sorted(set(re.findall(r"^(\S+?):\d+:\d+: error", text, re.M))) or [text]:
                yield path + ": not laid out by .clang-format: run `make format`"


LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
PLACE = re.compile(r"`((?:firmware|shared|host|tools|docs|hil_tests)/[\w./*-]*)`")


def slug(heading):
    return re.sub(r"[^\w\- ]", "", re.sub(r"`", "", heading).strip().lower()).replace(" ", "-")


def broken_links(path, text, exists, read_text):
    plain = re.sub(r"```.*?```", tree.blank_all, text, flags=re.S)
    for match in LINK.finditer(plain):
        target, _, anchor = match.group(1).partition("#")
        if re.match(r"[a-z]+:", match.group(1)):
            continue
        line = tree.line_of(plain, match.start())
        file = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
        if not exists(file):
            yield "%s:%d: link to %s, which does not exist" % (path, line, file)
        elif anchor and anchor not in {slug(h) for h in re.findall(r"^#+ +(.*)$", read_text(file), re.M)}:
            yield "%s:%d: %s has no heading #%s" % (path, line, file, anchor)
    for match in PLACE.finditer(plain):
        if not exists(match.group(1).rstrip("/")):
            yield "%s:%d: names %s, which does not exist" % (path, tree.line_of(plain, match.start()), match.group(1))


def package_faults(text, makefile):
    sections, section = {}, None
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        head = re.fullmatch(r"\[([a-z]+)\]", line)
        if head:
            section = head.group(1)
            if section in sections:
                yield "tools/packages.txt:%d: section [%s] stands twice" % (number, section)
            sections.setdefault(section, [])
        elif section is None:
            yield "tools/packages.txt:%d: '%s' stands before the first section" % (number, line)
        elif not re.fullmatch(r"[a-z0-9][a-z0-9.+-]+", line):
            yield "tools/packages.txt:%d: '%s' is no Debian package name" % (number, line)
        elif line in sections[section]:
            yield "tools/packages.txt:%d: %s stands twice in [%s]" % (number, line, section)
        else:
            sections[section].append(line)
    for name, packages in sections.items():
        if not packages:
            yield "tools/packages.txt: section [%s] is empty" % name
    for name in sorted(set(re.findall(r"\bpackages-([a-z]+)", makefile))):
        if name not in sections:
            yield "Makefile: packages-%s has no section in tools/packages.txt" % name


def undocumented_targets(makefile):
    """Every phony target and every plain-named rule has a ## comment."""
    phony = set(" ".join(re.findall(r"^\.PHONY:(.*)$", makefile, re.M)).split())
    rules = set(re.findall(r"^([a-z][a-z0-9-]*):(?!=)", makefile, re.M))
    told = set(re.findall(r"^([a-z0-9%-]+):.*?## \S", makefile, re.M))
    for name in sorted((phony | rules) - told):
        yield "Makefile: target %s has no ## comment, so `make help` hides it" % name
    for name in sorted(rules - phony):
        yield "Makefile: target %s is missing in .PHONY" % name


# --- self-tests -----------------------------------------------------------------------------------------------------
def self_test_code(report):
    long_body = "int f(void)\n{\n" + "    g();\n" * FUNCTION_LINES_MAX + "}\n"
    report.catches("a long C function is caught", long_functions("a.c", long_body))
    report.catches("a long method inside a namespace and a class is caught",
                   long_functions("a.cpp", "namespace a {\nclass B : public C {\n" + long_body + "};\n}\n"))
    report.catches("a long Python function is caught", long_functions("a.py", "def f():\n" + "    g()\n" * 80))
    report.catches("a long file is caught", long_file("a.c", "\n" * (FILE_LINES_MAX + 1)))
    report.accepts("a file of exactly the limit is accepted", long_file("a.c", "\n" * FILE_LINES_MAX))
    report.catches("a long line is caught", long_lines("a.md", "a" * (LINE_LETTERS_MAX + 1)))
    report.accepts("one of exactly the limit is accepted", long_lines("a.md", "a" * LINE_LETTERS_MAX + "\n"))
    report.accepts("so is a long row of a table", long_lines("a.md", "|" + " a |" * 60))
    report.catches("but only in a document", long_lines("a.py", "|" + " a |" * 60))
    report.catches("the earlier name of the project is caught in a line",
                   earlier_name("a.c", "int s" "eld_step(void);"))
    report.catches("and in a path", earlier_name("60-S" "eldinger.rules", ""))
    report.accepts("what happens rarely may be said in either way", earlier_name("a.c", "/* seldom */"))
    report.catches("a list of callers is caught", callers("a.c", "/* Sums. Called" " by: b.c. */"))
    report.catches("so is one of includes", callers("a.c", "// Sums. May" " include: b.hpp."))
    report.catches("a mark of unfinished work is caught", unfinished("a.c", "/* TO" "DO later */"))
    for word in BANNED:
        report.catches("banned word %s is caught" % word, banned_words("a.c", "void f(void) { %s(1); }" % word))
    report.catches("a second way from numbers to text is caught",
                   other_readers_and_numbers("host/a.cpp", 'char t[9]; std::snprintf(t, 9, "%g", 1.0);'))
    report.catches("an include of toml++ is caught",
                   other_readers_and_numbers("host/a.cpp", '#include "host/base/toml.hpp"\n'))
    report.accepts("formatted() is accepted",
                   other_readers_and_numbers("host/a.cpp", 'return formatted("%g", 1.0); // as snprintf does'))
    report.catches("a banned word in a macro is caught", banned_words("a.c", "#define SIZE(x) ((float)(x))\n"))
    report.accepts("banned words in comments, strings, includes and longer names are accepted",
                   banned_words("a.c", '#include <float.h>\n/* free */ int set_free_count(void) { return "sin"[0]; }'))
    report.catches("division by a variable is caught",
                   variable_division("a.c", "int f(int a, int b) { return a / b; }"))
    report.catches("remainder by a variable is caught",
                   variable_division("a.c", "int f(int a, int b) { return a %= (b); }"))
    report.accepts("division by a constant is accepted",
                   variable_division("a.c", "int a = b / 8 + c % CRN_MAX / (int)sizeof(d);"))
    report.catches("direct recursion is caught", recursion({"a.c": "int f(int a) { return f(a - 1); }"}))
    report.catches("recursion through another file is caught",
                   recursion({"a.c": "int f(int a)\n{ return g(a); }", "b.c": "int g(int a)\n{ return f(a); }"}))
    report.accepts("calls without a way back are accepted",
                   recursion({"a.c": "int f(int a) { return g(a); }\nint g(int a) { return a; }"}))
    with tempfile.TemporaryDirectory() as folder:
        bad = os.path.join(folder, "bad.c")
        with open(bad, "w", encoding="ascii") as file:
            file.write("int   f( void ){return 1 ;}\n")
        report.catches("a file that is not laid out is caught", layout([bad]))


def self_test_documents(report):
    def nothing(_):
        return False

    report.catches("a broken link is caught", broken_links("docs/a.md", "[a](b.md)", nothing, str))
    report.catches("a broken anchor is caught", broken_links("docs/a.md", "# B\n[a](#c)", lambda f: True,
        lambda f: "# B\n"))
    report.catches("a path that does not exist is caught",
                   broken_links("docs/a.md", "see `host/x/y.cpp`", nothing, str))
    report.accepts("a good anchor and a web address are accepted",
                   broken_links("docs/a.md", "[a](#b-c) [d](https://e.org)", lambda f: True, lambda f: "## B `c`\n"))
    report.catches("a package twice in a section is caught", package_faults("[run]\na1\na1\n", ""))
    report.catches("a section twice is caught", package_faults("[run]\na1\n[run]\nb2\n", ""))
    report.catches("an empty section is caught", package_faults("[run]\n[test]\na1\n", ""))
    report.catches("a package with a space is caught", package_faults("[run]\na1 b2\n", ""))
    report.catches("a make target without its section is caught", package_faults("[run]\na1\n", "x: packages-bench\n"))
    report.catches("an undocumented target is caught", undocumented_targets(".PHONY: a\na: b\n"))
    report.catches("a target missing in .PHONY is caught", undocumented_targets("a: b ## text\n"))
    report.accepts("a documented target is accepted", undocumented_targets(".PHONY: a\na: b ## text\nX := 1\n"))


# --- the tree -------------------------------------------------------------------------------------------------------
def exists(path):
    """Returns whether the path exists in the source tree; of a pattern, only the folder before its first star is
    tested."""
    if "*" in path:
        path = os.path.dirname(path[: path.index("*")])
    return os.path.exists(os.path.join(tree.ROOT, path))


def findings_of(rule, paths):
    return [finding for path in paths for finding in rule(path, tree.read(path))]


def check_tree(report):
    sources = tree.files(*tree.C_SUFFIXES)
    written = tree.files(*tree.C_SUFFIXES, ".py", ".sh", "Makefile", ".mk", ".def")
    device = [p for p in sources if p.startswith(DEVICE) and "/tests/" not in p]
    report.check("there is device code to check", [] if device else ["no file below " + ", ".join(DEVICE)])
    report.check("no function is longer than %d lines" % FUNCTION_LINES_MAX,
                 findings_of(long_functions, [p for p in written if p.endswith(tree.C_SUFFIXES + (".py",))]))
    report.check("no line is longer than %d letters" % LINE_LETTERS_MAX,
                 findings_of(long_lines, [p for p in tree.files("") if not p.endswith(tuple(LONG_LINES))]))
    report.check("no file is longer than %d lines" % FILE_LINES_MAX, findings_of(long_file, written))
    report.check("nothing has the earlier name of the project",
                 findings_of(earlier_name, [p for p in tree.files("") if not p.endswith(PACKED)]))
    report.check("no file lists its callers, or what it may include", findings_of(callers, written))
    report.check("nothing is marked as unfinished",
                 findings_of(unfinished, written + tree.files(".md", ".toml", ".txt")))
    report.check("the device uses no floating point, heap, libm, printf or goto", findings_of(banned_words, device))
    report.check("host and tools make text from numbers, and read TOML, in one way",
                 findings_of(other_readers_and_numbers,
                             [p for p in sources if p.startswith(("host/", "tools/")) and "/tests/" not in p
                              and p.endswith((".cpp", ".hpp"))]))
    report.check("the core divides by constants only",
                 findings_of(variable_division, [p for p in device if p.startswith("firmware/core/")]))
    report.check("nothing on the device calls itself", recursion({path: tree.read(path) for path in device}))
    report.check("every C and C++ file is laid out by .clang-format", layout(sources))
    report.check("links and paths in the documents exist",
                 [f for path in tree.files(".md") for f in broken_links(path, tree.read(path), exists, tree.read)])
    makefile = "\n".join(tree.read(path) for path in tree.files("Makefile", ".mk"))
    report.check("tools/packages.txt is well formed and has every section that make uses",
                 package_faults(tree.read("tools/packages.txt"), makefile))
    report.check("every make target is documented", undocumented_targets(makefile))


def main():
    report = tree.Report()
    self_test_code(report)
    self_test_documents(report)
    check_tree(report)
    report.end()


if __name__ == "__main__":
    main()
