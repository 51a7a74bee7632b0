"""Reads the i.MX RT1062's registers from the crate imxrt-ral, which cargo fetches. The script reads the crate only as
data, and keeps it only under build/."""

import os
import re
import shutil
import subprocess

CRATE, VERSION = "imxrt-ral", "0.6.2"
CHIP = "imxrt1062"
MANIFEST = """[package]
name = "registers"
version = "0.0.0"
edition = "2018"
[lib]
path = "lib.rs"
[dependencies]
%s = "=%s"
""" % (CRATE, VERSION)
TIME_LIMIT_S = 180

# Unlike later versions, cargo 1.65 of Debian 12 reads the registry's index from a git repository by default.
SPARSE_SINCE = (1, 68)
SPARSE = [
    "--config",
    'source.crates-io.replace-with="sparse"',
    "--config",
    'source.sparse.registry="sparse+https://index.crates.io/"',
]


class CannotRead(Exception):
    """An error whose text gives the remedy."""


def vendor_command():
    """Returns the command `cargo vendor` and the environment that the installed version of cargo needs for it."""
    text = subprocess.run(["cargo", "--version"], stdout=subprocess.PIPE, check=True, universal_newlines=True).stdout
    version = tuple(int(n) for n in re.findall(r"\d+", text)[:2])
    if version >= SPARSE_SINCE:
        return ["cargo", "vendor", "--quiet", "vendor"], dict(os.environ)
    return ["cargo", "-Z", "sparse-registry", "vendor", "--quiet"] + SPARSE + ["vendor"], dict(
        os.environ, RUSTC_BOOTSTRAP="1"
    )


def fetch(folder):
    """Returns the crate's source folder, after fetching the crate into `folder` if the crate is not there yet."""
    source = os.path.join(folder, "vendor", CRATE, "src")
    if os.path.isfile(os.path.join(source, CHIP + ".rs")):
        return source
    if shutil.which("cargo") is None:
        raise CannotRead("cargo is missing: `apt-get install cargo`, or `make registers`, which does that")
    os.makedirs(folder, exist_ok=True)
    for name, text in (("Cargo.toml", MANIFEST), ("lib.rs", "")):
        with open(os.path.join(folder, name), "w", encoding="ascii") as file:
            file.write(text)
    try:
        command, environment = vendor_command()
        done = subprocess.run(
            command,
            env=environment,
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=TIME_LIMIT_S,
            check=False,
            universal_newlines=True,
        )
    except subprocess.TimeoutExpired as error:
        raise CannotRead("cargo vendor took more than %d s: is crates.io reachable?" % TIME_LIMIT_S) from error
    if done.returncode != 0 or not os.path.isdir(source):
        raise CannotRead(
            "cargo vendor could not fetch %s %s; is crates.io reachable? It says: %s"
            % (CRATE, VERSION, done.stdout.strip()[-300:])
        )
    return source


# --- the generated Rust source: modules with constants and a RegisterBlock each --------------------------------------
MODULE = re.compile(r"^(\s*)pub mod (\w+) \{$")
MEMBER = re.compile(
    r"^\s*(?:pub )?(\w+): (?:crate::\w+Register<u(8|16|32)>|\[u8; (\w+)\]|"
    r"\[crate::\w+Register<u(8|16|32)>; (\d+)usize\]|"
    r"\[(\w+)::RegisterBlock; (\d+)usize\]|(\w+)::RegisterBlock),$"
)
VALUE = re.compile(r"pub const (\w+): u(?:8|16|32) = (.+?)(?: << offset)?;")
DOC = re.compile(r'#\[doc = "(.*)"\]')


def number(text):
    return int(text, 0)  # digits may be grouped by _


class Block:
    """Describes one kind of peripheral by three tables: registers[name] = (offset, bits), fields[register][field] =
    (shift, bits), and values[register][field][number] = the text about this number."""

    def __init__(self, text):
        self.fields, self.values, self.layouts, self.registers = {}, {}, {}, {}
        self.parse(text.splitlines())
        self.lay_out("", 0, "")

    def parse(self, lines):
        path, depths, doc, inside = [], [], "", None
        for line in lines:
            module, member, value, said = MODULE.match(line), MEMBER.match(line), VALUE.search(line), DOC.search(line)
            if said:
                doc = said.group(1)
            elif module:
                path.append(module.group(2))
                depths.append(len(module.group(1)))
            elif "struct RegisterBlock" in line:
                inside = self.layouts.setdefault("/".join(path), [])
            elif inside is not None and member:
                inside.append(member.groups())
            elif line.strip() == "}":
                if inside is not None and len(line) - 1 == (depths[-1] + 4 if depths else 0):
                    inside = None
                elif depths and len(line) - 1 == depths[-1]:
                    path.pop()
                    depths.pop()
            elif value:
                self.take_value(path, value.group(1), value.group(2), doc)

    def take_value(self, path, name, text, doc):
        if len(path) >= 2 and name in ("offset", "mask"):
            shift, mask = self.fields.setdefault(path[-2], {}).get(path[-1], (0, 0))
            self.fields[path[-2]][path[-1]] = (
                (number(text), mask) if name == "offset" else (shift, number(text).bit_length())
            )
        elif len(path) >= 3 and path[-1] in ("R", "W", "RW"):
            self.values.setdefault(path[-3], {}).setdefault(path[-2], {})[number(text)] = doc

    def lay_out(self, layout, offset, suffix):
        """Reads one RegisterBlock of the Rust source and returns the offset that follows this block."""
        for name, bits, gap, array_bits, array, inner, count, single in self.layouts[layout]:
            if gap:
                offset += number(gap)
            elif inner or single:
                for index in range(int(count or 1)):
                    offset = self.lay_out(inner or single, offset, "%s[%d]" % (suffix, index) if count else suffix)
            else:
                width = int(bits or array_bits)
                offset = -(-offset // (width // 8)) * (width // 8)
                for index in range(int(array or 1)):
                    self.registers[name + suffix + ("[%d]" % index if array else "")] = (offset, width)
                    offset += width // 8
        return offset


class Description:
    """Holds the base address of every peripheral as bases[instance]; block(instance) returns the Block that describes
    its registers."""

    def __init__(self, source):
        self.source, self.bases, self.files, self.blocks = source, {}, {}, {}
        text = self.read(CHIP + ".rs")
        for part in text.split('#[path = "."]')[1:]:
            place = re.search(r'#\[path = "(blocks/.*)"\]', part)
            for name, address in re.findall(r"pub const (\w+): \*const RegisterBlock = (\w+) as", part):
                self.bases[name] = number(address)
                self.files[name] = place.group(1)
        if len(self.bases) < 50:
            raise CannotRead("%s: only %d peripherals found: has its form changed?" % (CRATE, len(self.bases)))

    def read(self, path):
        with open(os.path.join(self.source, path), encoding="utf-8") as file:
            return file.read()

    def block(self, instance):
        path = self.files[instance]
        if path not in self.blocks:
            self.blocks[path] = Block(self.read(path))
        return self.blocks[path]
