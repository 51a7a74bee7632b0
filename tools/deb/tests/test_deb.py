#!/usr/bin/env python3
"""Tests the Debian packages that make_packages.py makes from the programs of the build folder. The test checks their
fields, files, dependencies and bytes, lintian's messages, and that the programs find their data. The test installs
nothing; test_deb_installed.sh installs the packages into a bare Debian. Prints TAP."""

import glob
import gzip
import os
import re
import subprocess
import sys
import tempfile
import xml.dom.minidom

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "check"))
import tap  # noqa: E402
import tree  # noqa: E402

BUILD = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"))
MAKER = os.path.join(HERE, "..", "make_packages.py")
NAMES = ("cournand", "libcournand-dev", "libcournand0", "python3-cournand")
MODULE = "usr/lib/python3/dist-packages/cournand"
MUST_HOLD = {
    "cournand": (
        "usr/bin/cournand usr/bin/bake usr/bin/anatomy usr/bin/centreline usr/lib/cournand/records_postgres.so "
        "lib/udev/rules.d/60-cournand.rules usr/share/applications/cournand.desktop usr/share/man/man1/bake.1.gz "
        "usr/share/icons/hicolor/scalable/apps/cournand.svg usr/share/man/man1/cournand-run.1.gz "
        "usr/share/bash-completion/completions/cournand usr/share/fish/vendor_completions.d/cournand.fish "
        "usr/share/zsh/vendor-completions/_cournand usr/share/cournand/examples/scenes/aorta.tar.xz "
        "usr/share/cournand/examples/instruments/j_wire.toml usr/share/cournand/examples/stents/renal_6_0x18.toml "
        "usr/share/cournand/examples/sessions/demo.session usr/share/cournand/examples/cases/first_push.toml"
    ),
    "libcournand0": "usr/lib/LIB/libcournand.so.0",
    "libcournand-dev": (
        "usr/include/cournand.h usr/include/cournand_play.h usr/lib/LIB/libcournand.a usr/lib/LIB/libcournand.so "
        "usr/lib/LIB/pkgconfig/cournand.pc usr/lib/LIB/cmake/cournand/cournand-config.cmake "
        "usr/share/cournand/examples/library/round_the_arch.c"
    ),
    "python3-cournand": " ".join(
        "%s/%s" % (MODULE, name)
        for name in ("__init__.py", "py.typed", "_core.pyi", "data/scenes/aorta.scene", "data/instruments/j_wire.toml")
    ),
}
# What a package may need, as names of packages without their numbers of versions.
MAY_NEED = {
    "libcournand0": {"libc", "libccd", "libgcc-s", "libstdc++"},
    "libcournand-dev": {"libcournand", "libccd-dev", "libusb-1.0--dev"},
    "python3-cournand": {"libc", "libgcc-s", "libstdc++", "libcournand", "python", "python-numpy"},
}


def ask(*words, **options):
    """Returns the exit code of a command, and its output."""
    done = subprocess.run(
        words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, cwd=tree.ROOT, **options
    )
    return done.returncode, done.stdout.decode("utf-8", "replace")


def explain(faults):
    """Prints the faults below a test's line, and returns True if there are none."""
    for fault in faults:
        print("# " + str(fault).strip().replace("\n", "\n# "))
    return not faults


def field(path, name):
    return ask("dpkg-deb", "--field", path, name)[1].strip()


class Made:
    """Holds the packages, which are made once and unpacked."""

    def __init__(self, folder):
        self.folder = folder
        self.output = os.path.join(folder, "packages")
        self.code, self.said = ask(MAKER, "--build", BUILD, "--output", self.output)
        self.paths = {}
        for path in sorted(glob.glob(self.output + "/*.deb")):
            self.paths[field(path, "Package")] = path
            ask("dpkg-deb", "--extract", path, self.tree(field(path, "Package")))
        self.triplet = ask("dpkg-architecture", "-qDEB_HOST_MULTIARCH")[1].strip()

    def tree(self, package):
        return os.path.join(self.folder, package)

    def files(self, package):
        root = self.tree(package)
        return {
            os.path.relpath(os.path.join(folder, name), root)
            for folder, folders, names in os.walk(root)
            for name in names + folders
        }


def four_packages_are_made():
    return explain([] if MADE.code == 0 and tuple(sorted(MADE.paths)) == tuple(sorted(NAMES)) else [MADE.said])


def each_package_holds_what_its_users_look_for():
    faults = []
    for package, names in MUST_HOLD.items():
        wanted = {name.replace("LIB", MADE.triplet) for name in names.split()}
        faults += ["%s lacks %s" % (package, name) for name in sorted(wanted - MADE.files(package))]
        documents = {"usr/share/doc/%s/%s" % (package, name) for name in ("copyright", "copyright.included.gz")}
        faults += ["%s lacks %s" % (package, name) for name in sorted(documents - MADE.files(package))]
    module = [name for name in MADE.files("python3-cournand") if re.search(r"_core\.cpython-3\d+-.*\.so$", name)]
    return explain(faults + ([] if len(module) == 1 else ["the module is %s" % module]))


def no_file_is_in_two_packages():
    holders = {}
    for package in NAMES:
        for name in MADE.files(package):
            if not os.path.isdir(os.path.join(MADE.tree(package), name)):
                holders.setdefault(name, []).append(package)
    return explain(["%s: %s" % row for row in holders.items() if len(row[1]) > 1])


def every_file_is_where_debian_has_such_files():
    allowed = re.compile(r"^(usr(/(bin|include|lib|share).*)?|lib(/udev.*)?)$")
    return explain(
        [
            "%s: %s" % (package, name)
            for package in NAMES
            for name in sorted(MADE.files(package))
            if not allowed.match(name)
        ]
    )


def libraries_need_no_window_no_opengl_and_no_dicom():
    faults = []
    for package, allowed in MAY_NEED.items():
        needed = field(MADE.paths[package], "Depends").split(",")
        names = {
            re.sub(r"\d+$|(?<=[a-z])\d+(?=-)|(?<=-)\d+(?=-dev)", "", re.split("[ :]", one.strip())[0]) for one in needed
        }
        faults += ["%s needs %s" % (package, name) for name in sorted(names - allowed)]
    return explain(faults)


def packages_of_one_source_fit_together():
    version = field(MADE.paths["libcournand0"], "Version")
    needs = {package: field(MADE.paths[package], "Depends") for package in NAMES}
    faults = [] if "libcournand0 (= %s)" % version in needs["libcournand-dev"] else [needs["libcournand-dev"]]
    faults += [] if "libcournand0 (>= " in needs["python3-cournand"] else [needs["python3-cournand"]]
    faults += [] if "libcournand0" not in needs["cournand"] else [needs["cournand"]]
    return explain(faults)


def only_the_records_of_a_server_need_libpqxx():
    path = MADE.paths["cournand"]
    return explain(
        []
        if "libpqxx" in field(path, "Recommends") and "libpq" not in field(path, "Depends")
        else [field(path, "Depends"), field(path, "Recommends")]
    )


def lintian_has_no_complaint():
    code, said = ask("lintian", "--fail-on", "error,warning", "--no-user-dirs", "--allow-root", *MADE.paths.values())
    return explain([] if code == 0 and not re.search("^[EW]:", said, re.M) else [said or "exit code %d" % code])


def the_changelog_is_that_of_the_project():
    with gzip.open(
        os.path.join(MADE.tree("cournand"), "usr/share/doc/cournand/changelog.gz"), "rt", encoding="utf-8"
    ) as file:
        text = file.read()
    path = os.path.join(MADE.folder, "changelog")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    code, version = ask("dpkg-parsechangelog", "--file", path, "--show-field", "Version")
    items = len(re.findall("^- ", tree.read("docs/CHANGELOG.md").split("## 0.1.0")[1], re.M))
    faults = [] if code == 0 and version.strip() == field(MADE.paths["cournand"], "Version") else [version]
    return explain(
        faults
        + ([] if text.count("\n  * ") >= items > 5 else ["%d items, expected %d" % (text.count("\n  * "), items)])
    )


def every_library_whose_code_is_inside_has_its_licence_there():
    part = tree.read("NOTICE").split("Headers that become part of the programs\n")[1].split("\nLibraries that")[0]
    names = {line[4:38].strip() for line in part.splitlines() if re.match(r" {4}\S", line)}
    words = {"CLI11": "libcli11", "Dear ImGui": "libimgui", "Eigen": "libeigen3", "hidapi": "libhidapi"}
    words.update({"JSON for Modern C++": "nlohmann-json3", "libpqxx": "libpqxx", "toml++": "libtomlplusplus"})
    path = os.path.join(MADE.tree("python3-cournand"), "usr/share/doc/python3-cournand/copyright.included.gz")
    with gzip.open(path, "rt", encoding="utf-8") as file:
        text = file.read()
    faults = ["%s has no row in this test" % name for name in sorted(names - set(words))]
    faults += ["%s is missing in copyright.included" % name for name in words if words[name] not in text]
    return explain(faults + ([] if "Wenzel Jakob" in text else ["nanobind is missing in copyright.included"]))


def no_file_names_the_folder_it_was_built_in():
    faults = []
    for package in NAMES:
        code, said = ask("grep", "-rlaF", tree.ROOT, MADE.tree(package))
        faults += [said] if code != 1 else []
    return explain(faults)


def the_program_finds_its_data_beside_itself():
    root = MADE.tree("cournand")
    own = dict(os.environ, HOME=MADE.folder, XDG_CACHE_HOME=MADE.folder + "/cache", XDG_DATA_HOME=MADE.folder + "/data")
    session = os.path.join(MADE.folder, "short.session")
    with open(session, "w", encoding="ascii") as file:
        file.write("begin inserted 5 mm\nadvance 20 mm at 60 mm/s\n")
    program = os.path.join(root, "usr/bin/cournand")
    faults = []
    for words, expected in (
        (["case", "list"], "first_push "),
        (["instruments"], "j_wire "),
        (["info", "demo"], "aorta"),
        (["run", session, "--scene", "aorta", "--tool", "j_wire"], "final hash"),
    ):
        done = subprocess.run(
            [program] + words, cwd=MADE.folder, env=own, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
        )
        if done.returncode != 0 or expected not in done.stdout.decode():
            faults.append("cournand %s: exit code %d\n%s" % (" ".join(words), done.returncode, done.stdout.decode()))
    return explain(faults)


def the_menu_of_a_desktop_has_the_window_and_its_icon():
    share = os.path.join(MADE.tree("cournand"), "usr/share")
    code, said = ask("desktop-file-validate", share + "/applications/cournand.desktop")
    picture = xml.dom.minidom.parse(share + "/icons/hicolor/scalable/apps/cournand.svg").documentElement
    return explain([] if code == 0 and not said and picture.tagName == "svg" else [said or picture.tagName])


def zsh_looks_for_completion_where_the_package_has_it():
    code, said = ask("zsh", "-fc", "print -l $fpath")
    return explain([] if code == 0 and "/usr/share/zsh/vendor-completions" in said.split("\n") else [said])


def the_udev_rule_has_the_number_of_the_build():
    with open(os.path.join(BUILD, "CMakeCache.txt"), encoding="utf-8") as file:
        vendor, product = re.search(r"^CRN_USB_ID:\w+=(\w+):(\w+)$", file.read(), re.M).groups()
    with open(os.path.join(MADE.tree("cournand"), "lib/udev/rules.d/60-cournand.rules"), encoding="utf-8") as file:
        text = file.read()
    return text.count('idVendor}=="%s"' % vendor) == 2 and text.count('idProduct}=="%s"' % product) == 2


def the_same_build_gives_the_same_bytes_again():
    again = os.path.join(MADE.folder, "again")
    other = dict(os.environ, TZ="Pacific/Auckland", LANG="C", LC_ALL="C")
    code, said = ask("sh", "-c", 'umask 077; exec "$@"', "sh", MAKER, "--build", BUILD, "--output", again, env=other)
    faults = [] if code == 0 else [said]
    for package, path in MADE.paths.items():
        if ask("cmp", path, os.path.join(again, os.path.basename(path)))[0] != 0:
            faults.append("%s differs" % package)
    return explain(faults)


def what_is_missing_is_named_with_its_remedy():
    faults = []
    output = os.path.join(MADE.folder, "none")
    for words, wrong, expected in (
        (["--build", MADE.folder], {}, "bin/cournand has not been built. Remedy: make deb"),
        (["--build", BUILD], {"SOURCE_DATE_EPOCH": "today"}, "SOURCE_DATE_EPOCH is 'today'. Remedy: "),
    ):
        code, said = ask(MAKER, "--output", output, *words, env=dict(os.environ, **wrong))
        if code != 1 or expected not in said or os.path.exists(output):
            faults.append("exit code %d: %s" % (code, said))
    return explain(faults)


with tempfile.TemporaryDirectory() as work:
    MADE = Made(work)
    tap.run(
        [
            four_packages_are_made,
            each_package_holds_what_its_users_look_for,
            no_file_is_in_two_packages,
            every_file_is_where_debian_has_such_files,
            libraries_need_no_window_no_opengl_and_no_dicom,
            packages_of_one_source_fit_together,
            only_the_records_of_a_server_need_libpqxx,
            lintian_has_no_complaint,
            the_changelog_is_that_of_the_project,
            every_library_whose_code_is_inside_has_its_licence_there,
            no_file_names_the_folder_it_was_built_in,
            the_program_finds_its_data_beside_itself,
            the_menu_of_a_desktop_has_the_window_and_its_icon,
            zsh_looks_for_completion_where_the_package_has_it,
            the_udev_rule_has_the_number_of_the_build,
            the_same_build_gives_the_same_bytes_again,
            what_is_missing_is_named_with_its_remedy,
        ]
    )
