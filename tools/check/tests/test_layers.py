#!/usr/bin/env python3
"""These tests check the following. A source file includes only files of lower layers, from the folders that this test
permits. Prints TAP."""

import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

# Folder -> what its files may include besides their own folder. The longest matching row counts. An entry is a folder
# (and below) or one file. CORE_PUBLIC is what the core shows to tools and host.
CORE_PUBLIC = [
    "firmware/core/core.h",
    "firmware/core/lumen.h",
    "firmware/core/vector.h",
    "firmware/core/fixed.h",
    "firmware/core/rhythm.h",
    "firmware/core/motion.h",
    "firmware/core/lesion.h",
]
# Files that the command lines of all tools share.
COMMAND_LINE = [
    "host/base/command_values.hpp",
    "host/base/format.hpp",
    "host/base/number_text.hpp",
    "host/base/version.hpp",
    "host/base/output_files.hpp",
    "host/base/terminal.hpp",
]
# Tests of a room may use every other room of the host; test_usb has a USB bus of simulated ports.
LONG_RUN = "firmware/tests/reference/long_run.h"
FLOW = ["host/effects", "host/model", "host/base", "shared"]
HOST_TESTS = ["host", "shared", "firmware/port/sim/sim.h", "firmware/core/core.h", LONG_RUN]
ALLOWED = {
    "firmware/core": [],
    "firmware/app": [
        "firmware/app/haptics",
        "firmware/app/safety",
        "firmware/core",
        "shared",
        "firmware/port/port.h",
    ],
    # Code that can hurt a finger uses only samples, numbers and its own memory; it uses neither the app, nor the
    # wire, nor the core.
    "firmware/app/safety": ["firmware/port/port.h", "shared/wire/fault_code.h"],
    "firmware/app/haptics": [
        "firmware/app/safety/arithmetic.h",
        "firmware/app/safety/finding.h",
        "firmware/app/safety/limits.h",
        "firmware/core/fixed.h",  # arithmetic
    ],
    # The USB stack depends on the controller's contract and the wire, but not on the app; code in a port joins the
    # stack and the app.
    "firmware/app/usb": ["firmware/port/udc.h", "shared/wire"],
    "firmware/port": [],  # port.h and udc.h, the hardware contracts that the app requires and every port fulfils
    "firmware/port/usb": ["firmware/app", "firmware/port/port.h", "firmware/port/udc.h", "shared/wire"],
    "firmware/port/mailbox": ["firmware/port/udc.h", "shared/mailbox"],
    "firmware/port/sim": ["firmware/app", "firmware/port/port.h"],
    "firmware/port/mps2_an500": [],
    "firmware/port/mps2_an500/device": [
        "firmware/app",
        "firmware/port/port.h",
        "firmware/port/console_digits.h",
        "firmware/port/mps2_an500",
        "firmware/port/usb",
        "firmware/port/mailbox",
        "shared/mailbox",
    ],
    "firmware/port/imxrt1062": [
        "firmware/app",
        "shared/wire/wire_frame.h",  # CRC-32 of the image
        "firmware/port/port.h",
        "firmware/port/console_digits.h",
        "firmware/port/udc.h",
        "firmware/port/usb",
    ],
    "firmware/port/libc": [],
    "firmware/tests": ["firmware", "shared"],
    "firmware/tests/board": ["firmware", "shared"],
    "firmware/tests/reference": [
        "firmware/core",
        "firmware/app",
        "firmware/port/sim/sim.h",
        "firmware/port/port.h",
        "shared",
    ],
    "firmware/bench": ["firmware", "shared"],
    "shared": [],  # version.h
    "shared/wire": [],
    "shared/scene": ["shared/wire/wire_frame.h"],  # CRC-32
    "shared/mailbox": [],
    "shared/wire/tests": ["shared", "firmware/tests/reference"],
    "shared/scene/tests": ["shared", "firmware/tests/reference"],
    "host/link": ["host/base", "shared", "firmware/port/sim/sim.h", "firmware/port/mps2_an500/rig_page.h"],
    "host/base": ["shared/version.h"],
    "host/cli": ["host/base"],  # the command lines of all programs
    "host/model": ["host/base", "shared"],
    "host/xray/paths": ["host/model", "host/base"],
    "host/xray/volume": ["host/xray/paths", "host/model", "host/base"],
    "host/xray": ["host/xray/paths", "host/xray/volume", "host/model", "host/base"],
    "host/xray/style": ["host/xray", "host/xray/paths", "host/model", "host/base"],
    "host/xray/gl": ["host/xray", "host/model", "host/base"],
    "host/dicom": ["host/xray", "host/model", "host/base"],  # the only folder that uses DCMTK
    "host/effects": FLOW[1:],
    "host/room": ["host/xray", "host/base"],
    "host/stent": ["host/model", "host/base"],  # and libccd
    "host/complications": ["host/room/command.hpp", "host/base"],
    "host/patient": ["host/complications", "host/room", "host/xray", "host/stent", *FLOW],
    "host/rig": ["host/link", "host/room/command.hpp", "host/base", "shared"],
    "host/script": ["host/patient", "host/room", *FLOW],
    # Recordings hold the wire's own records.
    "host/session": [
        "host/script",
        "host/rig",
        "host/patient",
        "host/room",
        "host/stent",
        "host/effects/pulse.hpp",
        "host/link",
        "host/model",
        "host/base",
        "shared",
    ],
    "host/cases": [
        "host/session",
        "host/script",
        "host/patient",
        "host/model",
        "host/base",
        "shared/scene/scene.h",  # the version of scenes
    ],
    "host/cases/tests": HOST_TESTS,
    "host/picture": [
        "host/session/frame_sink.hpp",
        "host/patient",
        "host/room",
        "host/dicom",
        "host/effects",
        "host/xray",
        "host/model",
        "host/base",
    ],
    # The only room that uses libOpenIGTLink; it reads a session and never steers it.
    "host/igtl": [
        "host/session/frame_sink.hpp",
        "host/picture",
        "host/patient",
        "host/room",
        "host/xray",
        "host/model",
        "host/base",
    ],
    "host/igtl/tests": HOST_TESTS,
    # The report of a session, without pictures, for the C library, too.
    "host/report/figures": [
        "host/session",
        "host/script",
        "host/patient",
        "host/room",
        *FLOW,
    ],
    "host/report": [
        "host/report/figures",
        "host/picture/picture.hpp",
        "host/picture/canvas.hpp",
        "host/session",
        "host/patient",
        "host/room",
        "host/effects",
        "host/model",
        "host/base",
        "shared",
    ],
    # The only room that uses SQLite and libpqxx; it knows neither cases nor reports.
    "host/records": ["host/base"],
    "host/assess": [
        "host/report",
        "host/session",
        "host/script",
        "host/patient",
        "host/room",
        "host/xray",
        "host/model",
        "host/base",
        "shared",
    ],
    # The rooms that need GLFW: a program without a window is built without them.
    "host/screen": ["host/picture/picture.hpp", "host/xray/gl"],
    "host/live": ["host", "shared"],  # sessions in threads, without a window
    "host/suite": ["host", "shared"],
    # The C library needs no window, no OpenGL, no DICOM and no command line.
    "host/library": [
        "host/report/figures",
        "host/session",
        "host/script",
        "host/patient",
        "host/stent",
        "host/link",
        "host/xray",
        "host/model",
        "host/base",
        "shared",
    ],
    "host/library/tests": HOST_TESTS,
    # The Python module knows the C library's headers and nothing else of the project.
    "host/python/module": ["host/library/cournand.h", "host/library/cournand_play.h"],
    # The command line as a library, so that tests run whole commands in their process; the window comes as a function.
    "host/command": ["host", "shared", "firmware/core/core.h"],
    "host/app": ["host/suite", "host/command"],  # the program: main
    "host/app/tests": HOST_TESTS,
    "host/bench": ["host", "firmware/bench/bench.h"],
    "host/base/tests": HOST_TESTS,
    "host/cli/tests": HOST_TESTS,
    "host/complications/tests": HOST_TESTS,
    "host/dicom/tests": HOST_TESTS,
    "host/effects/tests": HOST_TESTS,
    "host/link/tests": HOST_TESTS,
    "host/live/tests": HOST_TESTS,
    "host/model/tests": HOST_TESTS,
    "host/patient/tests": HOST_TESTS,
    "host/picture/tests": HOST_TESTS,
    "host/records/tests": HOST_TESTS,
    "host/report/tests": HOST_TESTS,
    "host/rig/tests": HOST_TESTS,
    "host/room/tests": HOST_TESTS,
    "host/script/tests": HOST_TESTS,
    "host/session/tests": HOST_TESTS,
    "host/stent/tests": HOST_TESTS,
    "host/suite/tests": HOST_TESTS,
    "host/xray/tests": HOST_TESTS,
    "tools/bake": [
        "shared",
        "host/model",
        "host/base",
        "host/cli/parse.hpp",
        "tools/mesh",
        "tools/centreline/tree.hpp",
        "tools/centreline/join.hpp",
        "tools/centreline/formats.hpp",
    ]
    + CORE_PUBLIC,
    "tools/centreline": [
        "tools/mesh",
        "host/base/format.hpp",
        "host/base/guarded_read.hpp",
        "host/base/number_text.hpp",
        "host/base/pending_file.hpp",
    ],
    # The window and pictures are the host's, which know nothing of it.
    "tools/centreline/fit": [
        "tools/centreline",
        "tools/bake",
        "tools/mesh",
        "host/model",
        "host/base",
        "host/cli/parse.hpp",
        "host/picture/picture.hpp",
        "host/picture/canvas.hpp",
        "host/screen/screen.hpp",
    ],
    "tools/centreline/tests": ["tools/centreline", "tools/bake", "tools/mesh", "host/model", "host/base"],
    "tools/centreline/program": COMMAND_LINE + ["tools/centreline/fit", "tools/patient", "host/cli/parse.hpp"],
    "tools/patient": ["tools/centreline", "tools/bake", "tools/mesh", "host/base", "shared/scene/scene.h"],
    "tools/patient/tests": ["tools", "host/base", "host/model", "host/effects"],
    "tools/anatomy": [
        "shared",
        "host/model",
        "host/base",
        "host/cli/parse.hpp",
        "tools/mesh",
        "tools/bake/mesh.hpp",
    ]
    + CORE_PUBLIC,
    # Frame counts need the anatomy's vessels as a tree of blood flow, which `bake` makes.
    "tools/timi": ["tools/anatomy", "tools/bake", "host/effects", "host/model"],
    "tools/chip": ["host", "shared", "firmware/bench/budget_case.h"],
    # What Frama-C analyses, and nobody compiles.
    "tools/safety/eva": ["firmware/app/safety", "firmware/core"],
    "tools/mutants": [],  # an object that the tests' programs are linked with
    "tools/importers": [  # one program calls the readers of all tools for `make importers`
        "host/base/version.hpp",
        "host/base/toml.hpp",
        "tools/mesh/files/mesh_file.hpp",
        "tools/centreline/formats.hpp",
        "tools/lab/ct/volume/volume_io.hpp",
    ],
    "tools/lab/case": ["host/base", "shared/wire/wire.h"],
    "tools/lab/reference_rod": COMMAND_LINE
    + [
        "tools/lab/case",
        "tools/lab/vcsim3/lumen.hpp",
        "host/model/instrument.hpp",
        "host/base/pending_file.hpp",
        "shared/wire/wire.h",
    ],
    "tools/lab/reference_rod/tests": [
        "tools/lab/reference_rod",
        "tools/lab/validate/elastica.hpp",
        "firmware/tests/reference",
    ],
    "tools/lab/case/tests": ["tools/lab/case", "host/base/tests/folder.hpp"],
    # Pictures, tables and the reader of scenes are those of the thesis' baseline; core_rod.cpp owns the core's memory.
    "tools/lab/calibrate": [
        "tools/lab/case",
        "tools/lab/vcsim3",
        "tools/lab/figures",
        "shared/wire",
        "host/model",
        "host/base",
        "host/base/progress_line.hpp",
    ]
    + CORE_PUBLIC,
    "tools/lab/calibrate/tests": [
        "tools/lab/calibrate",
        "tools/lab/case",
        "host/model",
        "host/base",
        "host/base/tests/folder.hpp",
    ],
    "tools/lab/ct": [
        "tools/lab/case",
        "tools/lab/reference_rod/truth.hpp",
        "tools/lab/reference_rod/truth_options.hpp",
        "tools/bake",
        "tools/mesh",
        "host/model",
        "host/base",
        "host/xray",
        "host/picture/canvas.hpp",
    ],
    "tools/lab/ct/program": COMMAND_LINE
    + [
        "tools/lab/ct",
        "host/cases/programs.hpp",
        "host/base/text.hpp",
        "tools/lab/reference_rod/truth_options.hpp",
        "tools/patient",
    ],
    # The window of a patient's CT draws with the suite's parts, and runs the command `ct patient`.
    "tools/lab/ct/review": ["tools/lab/ct/patient", "tools/lab/ct/arteries", "tools/centreline", "tools/bake", "host"],
    "tools/lab/ct/arteries": ["tools/lab/ct", "tools/centreline", "tools/mesh", "host", "shared/wire/wire_frame.h"],
    "tools/lab/ct/arteries/tests": ["tools/lab/ct", "tools/mesh", "host/base/tests/folder.hpp"],
    "tools/lab/ct/patient": [
        "tools/lab/ct",
        "tools/centreline",
        "tools/patient",
        "tools/bake",
        "tools/mesh",
        "host/model",
        "host/base",
        "host/xray",
        "host/picture/picture.hpp",
    ],
    "tools/lab/ct/tests": ["tools/lab/ct", "tools/lab/case", "tools/bake", "tools/mesh", "host/base/tests/folder.hpp"],
    "tools/mesh": [
        "host/base/fault.hpp",
        "host/base/guarded_read.hpp",
        "host/base/interrupt.hpp",
        "host/base/number_range.hpp",
        "host/base/number_text.hpp",
        "host/base/progress_line.hpp",
    ],
    # The one room that knows OpenVDB.
    "tools/mesh/level_set": ["tools/mesh"],
    "tools/mesh/files": ["tools/mesh", "host/base/guarded_read.hpp"],
    # core_hash.c owns the core's memory and reads it; it also runs on a bare board.
    # Owns the memory of models and states (rig.cpp).
    "tools/lab/validate": COMMAND_LINE + ["firmware/core", "host/base/pending_file.hpp"],
    "tools/lab/literature": ["host", "tools/anatomy", "tools/bake", "tools/lab/validate", "tools/mesh", "tools/timi"],
    "tools/check": CORE_PUBLIC
    + ["firmware/core/core_state.h", "firmware/core/rod_block.h", "firmware/port/mps2_an500"],
    "tools/docs": ["host/base/number_text.hpp", "shared/version.h", "shared/wire", "firmware/app/usb/usb_table.def"],
    "tools/lab/vcsim3": ["shared/scene"] + CORE_PUBLIC,
    # Two files of the host write the pictures; these files use nothing else of the host.
    "tools/lab/figures": COMMAND_LINE
    + [
        "tools/lab/vcsim3",
        "shared/scene",
        "host/base/interrupt.hpp",
        "host/base/pending_file.hpp",
        "host/picture/picture.hpp",
        "host/picture/font.hpp",
    ]
    + CORE_PUBLIC,
    "tools/lab/vcsim3/tests": ["tools/lab/vcsim3", "tools/lab/figures", "firmware/tests/reference"] + CORE_PUBLIC,
    "tools/lab/peers": ["firmware", "shared", "host"],
    "hil_tests/plant": ["firmware/port/port.h"],
    "hil_tests/l0": [
        "firmware/port/port.h",
        "firmware/port/sim/sim.h",
        "hil_tests/plant",
        "hil_tests/cases/bench.hpp",
        "host/link",
    ],
    "hil_tests/l1": [
        "firmware/port/port.h",
        "firmware/port/mps2_an500/rig_page.h",
        "hil_tests/plant",
        "hil_tests/cases/bench.hpp",
        "host/link",
    ],
    "hil_tests/cases": ["hil_tests/" + part for part in ("plant", "l0", "l1")]
    + ["host", "shared", "firmware/tests/reference"],
    "hil_tests/cases/tests": ["hil_tests", "host", "firmware/tests/reference/long_run.h"],
    "hil_tests/campaign": ["hil_tests/cases", "hil_tests/l0", "hil_tests/l1", "hil_tests/plant", "host", "shared"],
    "hil_tests/campaign/tests": ["hil_tests"],
    # These tests run whole commands, from command line to exit code, with a bus of their own in place of libusb.
    "hil_tests/lies": [
        "hil_tests/campaign/faulty_pipe.hpp",
        "hil_tests/cases/conversation.hpp",
        "host",
        "shared",
        "firmware/port/sim/sim.h",
    ],
    "hil_tests/lies/tests": ["hil_tests/lies", "firmware/tests/reference/long_run.h"],
    "hil_tests/soak": ["host", "shared"],
    "hil_tests/soak/tests": ["hil_tests/soak", "host"],
    "hil_tests/hours": ["firmware/app", "firmware/port", "hil_tests", "host", "shared"],
    "hil_tests/l1/tests": ["host/link", "hil_tests/usb", "shared"],
    "hil_tests/plant/tests": ["hil_tests/plant"],
    # These tests exchange bytes with the device: reference/client.h is the smallest host, tools/bake computes distance.
    "hil_tests": [
        "shared",
        "hil_tests/usb",
        "firmware/tests/reference",
        "firmware/port/sim/sim.h",
        "host",
        "tools/bake",
    ],
    "hil_tests/rig": ["hil_tests/plant", "hil_tests/l1", "host"],
    "hil_tests/l2": ["hil_tests/usb"],
    "hil_tests/l3": ["hil_tests/usb"],
    "hil_tests/l4": ["shared/wire", "firmware/tests/reference"],
    "hil_tests/library": ["shared/wire", "firmware/tests/reference"],
    "hil_tests/rt1062": ["firmware/port", "hil_tests/usb", "shared"],
    "hil_tests/rt1062/bench": ["firmware/port", "hil_tests", "host", "shared"],
    "hil_tests/rt1062/faults": ["hil_tests", "host"],
    "hil_tests/usb": ["shared", "firmware/app", "firmware/port"],
}

# System headers: the firmware side is freestanding, so its list is closed. Folders not named may include any.
FREESTANDING = {"stdint.h", "stddef.h", "stdbool.h", "limits.h"}
SYSTEM = {
    "firmware/core": FREESTANDING,
    "firmware/app": FREESTANDING | {"string.h"},
    "firmware/app/safety": FREESTANDING,
    "firmware/app/haptics": FREESTANDING,
    "firmware/app/usb": FREESTANDING,
    "firmware/port/usb": FREESTANDING,
    "firmware/port/mailbox": FREESTANDING,
    "shared/mailbox": FREESTANDING,
    "firmware/port": FREESTANDING,
    "firmware/port/sim": FREESTANDING | {"string.h", "stdlib.h"},
    "firmware/port/mps2_an500": FREESTANDING,
    "firmware/port/imxrt1062": FREESTANDING,
    "firmware/port/libc": FREESTANDING,
    "shared/wire": FREESTANDING | {"string.h"},
    "shared/scene": FREESTANDING | {"string.h"},
}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+(?:"([^"]+)"|<([^>]+)>)', re.M)


def is_below(path, place):
    return path == place or path.startswith(place + "/")


def row_of(path, table):
    rows = [row for row in table if is_below(os.path.dirname(path), row)]
    return max(rows, key=len) if rows else None


def includes(text):
    """Yields (line, quoted name or None, system name or None) of every #include line; comments are ignored."""
    plain = re.sub(r"/\*.*?\*/", tree.blank_all, text, flags=re.S)
    for match in INCLUDE.finditer(plain):
        yield tree.line_of(plain, match.start(1) if match.group(1) else match.start(2)), match.group(1), match.group(2)


def check_quoted(path, line, target, row, exists):
    if not exists(target):
        return '%s:%d: "%s" does not exist from the root: includes are root-relative' % (path, line, target)
    if row_of(target, ALLOWED) == row or any(is_below(target, place) for place in ALLOWED[row]):
        return None
    return "%s:%d: %s may not include %s; allowed: itself%s" % (
        path,
        line,
        row,
        target,
        "".join(", " + place for place in ALLOWED[row]),
    )


def check_file(path, text, exists):
    """For one file, yields a finding for each include that the table ALLOWED does not permit."""
    row = row_of(path, ALLOWED)
    if row is None:
        yield "%s: its folder has no row in ALLOWED (tools/check/tests/test_layers.py)" % path
        return
    closed = SYSTEM.get(row)
    for line, quoted, system in includes(text):
        if quoted is not None:
            finding = check_quoted(path, line, quoted, row, exists)
            if finding:
                yield finding
        elif closed is not None and system not in closed and not is_test(path):
            yield "%s:%d: %s may not include <%s>; allowed: %s" % (path, line, row, system, ", ".join(sorted(closed)))


def is_test(path):
    return "/tests/" in path


def check_cycles(graph):
    """Yields header cycles. The search for circular includes repeatedly removes every file that includes no remaining
    file. The files that are left at the end include each other in a circle."""
    left = dict(graph)
    while True:
        free = [path for path, targets in left.items() if not any(t in left for t in targets)]
        if not free:
            break
        for path in free:
            del left[path]
    for path in sorted(left):
        yield "%s includes itself by way of %s" % (path, ", ".join(t for t in left[path] if t in left))


def include_graph(paths):
    return {path: [q for _, q, _ in includes(tree.read(path)) if q] for path in paths}


def self_test(report):
    def sample(path, text):
        return check_file(path, text, lambda target: True)

    report.catches(
        "an include from core into app is caught", sample("firmware/core/x.c", '#include "firmware/app/app.h"')
    )
    report.catches(
        "an include from model into xray is caught", sample("host/model/x.hpp", '\n# include "host/xray/a.hpp"')
    )
    report.catches(
        "an include of the core's private header by a tool is caught",
        sample("tools/bake/x.cpp", '#include "firmware/core/core_state.h"'),
    )
    report.catches(
        "an include of the app by the safety part is caught",
        sample("firmware/app/safety/x.c", '#include "firmware/app/app.h"'),
    )
    report.catches(
        "an include of the wire by the safety part is caught",
        sample("firmware/app/safety/x.c", '#include "shared/wire/wire.h"'),
    )
    report.catches(
        "an include of the core by the haptics is caught",
        sample("firmware/app/haptics/x.c", '#include "firmware/core/core.h"'),
    )
    report.catches(
        "an include of one shared library by the other is caught",
        sample("shared/wire/x.c", '#include "shared/scene/scene.h"'),
    )
    report.catches("a libc header in the core is caught", sample("firmware/core/x.c", "#include <math.h>"))
    report.catches("a file in an unlisted folder is caught", sample("firmware/new/x.c", ""))
    report.catches(
        "an include that is not root-relative is caught",
        check_file("firmware/core/x.c", '#include "fixed.h"', lambda target: False),
    )
    report.catches("a cycle of headers is caught", check_cycles({"a.h": ["b.h"], "b.h": ["a.h"]}))
    report.accepts(
        "allowed arrows and a commented include are accepted",
        list(sample("firmware/app/x.c", '#include "firmware/core/core.h"\n#include <string.h>'))
        + list(sample("firmware/core/x.c", "/*\n#include <math.h>\n*/"))
        + list(check_cycles({"a.h": ["b.h"], "b.h": []})),
    )


def main():
    report = tree.Report()
    self_test(report)
    paths = tree.files(*tree.C_SUFFIXES)

    def exists(target):
        return os.path.isfile(os.path.join(tree.ROOT, target)) and not target.startswith("..")

    findings = [finding for path in paths for finding in check_file(path, tree.read(path), exists)]
    report.check("every include is an arrow listed in the table of layers", findings)
    report.check("no header includes itself", check_cycles(include_graph(paths)))
    lines = tree.read("firmware/port/port.h").count("\n")
    report.check(
        "what a port implements fits into less than 100 lines",
        ["firmware/port/port.h has %d" % lines] if lines >= 100 else [],
    )
    report.end()


if __name__ == "__main__":
    main()
