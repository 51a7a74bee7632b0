#!/usr/bin/python3
"""Makes Debian packages from programs that are already built (`make deb`). The script compiles the Python module for
Debian's Python, writes the folder debian/, and calls debhelper, which sorts the installed files into packages.

  make_packages.py --build build --output out/deb

The script runs with Debian's own Python, because the compiled module works only with that version of Python. The same
commit and the same programs give packages with the same bytes. The variables DEBFULLNAME and DEBEMAIL set another
maintainer."""

import argparse
import fcntl
import glob
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "check"))
import pinned_environment  # noqa: E402
import release  # noqa: E402
from release import ROOT, Fault  # noqa: E402

PACKAGES = ("cournand", "libcournand0", "libcournand-dev", "python3-cournand")
BUILT = ("bin/cournand", "bin/bake", "bin/anatomy", "bin/centreline", "lib/libcournand.so", "lib/libcournand.a")
TOOLS = (("dh", "debhelper"), ("dh_python3", "dh-python"), ("cmake", "cmake"), ("ninja", "ninja-build"))
# Packages whose headers or static libraries become part of ours.
INCLUDED = ("libccd-dev", "libcli11-dev", "libeigen3-dev", "libhidapi-dev", "libimgui-dev", "libpqxx-dev", "libstb-dev")
INCLUDED += ("libtomlplusplus-dev", "nlohmann-json3-dev")
MAINTAINER = ("The Cournand authors", "maintainers@cournand.invalid")


def run(words, folder=ROOT, **variables):
    """Runs a command without printing its output; if the command fails, raises a Fault with the output."""
    variables = dict(os.environ, **variables)
    done = subprocess.run(
        words, cwd=folder, env=variables, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    said = done.stdout.decode(errors="replace")
    if done.returncode != 0:
        raise Fault("%s\n%s ended with exit code %d, in %s" % (said, " ".join(words), done.returncode, folder))
    return said


def check_machine(build):
    """Checks, before any work, that this machine can make packages, and raises a Fault if not."""
    for name in BUILT:
        if not os.path.isfile(os.path.join(build, name)):
            raise Fault("%s has not been built. Remedy: make deb" % os.path.join(build, name))
    for program, package in TOOLS:
        if not shutil.which(program):
            raise Fault("the program %s is missing. Remedy: sudo apt-get install %s" % (program, package))
    if not os.path.isfile("/usr/include/python3.%d/Python.h" % sys.version_info.minor):
        raise Fault(
            "Python %d.%d at %s is not Debian's, or its headers are missing. Remedy: sudo apt-get install python3-dev, "
            "then run this with /usr/bin/python3" % (sys.version_info[:2] + (sys.executable,))
        )


def build_module(build):
    """Compiles the Python module for use with the shared library, with nanobind's code included, and returns the
    module's folder."""
    folder = os.path.join(build, "deb", "module")
    try:
        python = pinned_environment.make(os.path.join(build, "deb", "venv"), os.path.join(HERE, "requirements.txt"))
    except (pinned_environment.EnvironmentFault, pinned_environment.PackagesFault) as fault:
        raise Fault("%s\nRemedy: run this once with a network; it needs nanobind from PyPI" % fault) from fault
    if not os.path.exists(os.path.join(folder, "build.ninja")):
        library = os.path.join(build, "lib", "libcournand.so")
        words = ["cmake", "-G", "Ninja", "-S", os.path.join(ROOT, "host", "python", "module"), "-B", folder]
        words += ["-DCOURNAND_SPLIT=OFF", "-DCOURNAND_LIBRARY=" + library, "-DPython_EXECUTABLE=" + python]
        words += ["-DCMAKE_SKIP_RPATH=ON"]  # the module's bytes must not depend on the folder of the build
        run(words + ["-DCMAKE_CXX_FLAGS=-g1 -fdebug-prefix-map=%s=." % os.path.dirname(python)])
    run(["ninja", "-C", folder], LD_LIBRARY_PATH=os.path.join(build, "lib"))
    return folder


def set_usb_number(build, debian):
    """Writes the udev rule, and the number that the programs were built with into all that names a rig on USB."""
    shutil.copy(os.path.join(ROOT, "tools", "udev", "60-cournand.rules"), os.path.join(debian, "cournand.udev"))
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
        vendor, product = re.search(r"^CRN_USB_ID:\w+=(\w+):(\w+)$", file.read(), re.M).groups()
    for name in ("cournand.udev", "cournand.metainfo.xml"):
        with open(os.path.join(debian, name), encoding="utf-8") as file:
            text = file.read().replace('"1209"', '"%s"' % vendor).replace('"0001"', '"%s"' % product)
        write(debian, name, text.replace("usb:v1209p0001d", "usb:v%sp%sd" % (vendor.upper(), product.upper())))


def included_copyright(build):
    """Returns the copyright notices of all foreign code in the packages."""
    files = [(package, "/usr/share/doc/%s/copyright" % package) for package in INCLUDED]
    licence = build + "/deb/venv/lib/*/site-packages/nanobind-*/**/LICENSE"
    files += [("nanobind", path) for path in glob.glob(licence, recursive=True)]
    if len(files) == len(INCLUDED):
        raise Fault("nanobind's licence is not in %s/deb/venv. Remedy: remove that folder, then make deb" % build)
    texts = []
    for package, path in files:
        with open(path, encoding="utf-8") as file:
            texts.append("%s\n%s\n%s\n\n" % (package, "=" * len(package), file.read().strip()))
    return "\n".join(texts)


def metadata(number):
    """Returns the metadata by which Python's tools recognise an installed package."""
    return "Metadata-Version: 2.1\nName: cournand\nVersion: %s\nLicense: Apache-2.0\nRequires-Dist: numpy\n" % number


def write(folder, name, text):
    path = os.path.join(folder, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def stage(build, folder, number, date):
    """Writes the folder debian/ with all files that depend on the version or on the build."""
    shutil.rmtree(folder, ignore_errors=True)
    debian = os.path.join(folder, "debian")
    shutil.copytree(os.path.join(HERE, "debian"), debian)
    maintainer = "%s <%s>" % tuple(
        os.environ.get(name) or usual for name, usual in zip(("DEBFULLNAME", "DEBEMAIL"), MAINTAINER)
    )
    control = release.read("tools", "deb", "debian", "control").replace("@MAINTAINER@", maintainer)
    write(debian, "control", control)
    changelog = release.debian_changelog(
        release.read("docs", "CHANGELOG.md"), number.split("~")[0], number, maintainer, date
    )
    write(debian, "changelog", changelog)
    set_usb_number(build, debian)
    write(debian, "copyright.included", included_copyright(build))
    shutil.copy(os.path.join(ROOT, "NOTICE"), debian)
    for package in PACKAGES:
        write(debian, package + ".docs", "debian/NOTICE\ndebian/copyright.included\n")
    information = "cournand-%s.dist-info" % number.split("~")[0]
    write(debian, information + "/METADATA", metadata(number.split("~")[0]))
    write(debian, information + "/INSTALLER", "debian\n")


def make(build, output):
    """Makes the packages and returns their paths."""
    check_machine(build)
    date = release.seconds()
    os.makedirs(os.path.join(build, "deb"), exist_ok=True)
    with open(os.path.join(build, "deb", "lock"), "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two tests may begin at the same time
        return make_alone(build, output, date)


def make_alone(build, output, date):
    """Makes the packages, while a lock keeps other processes out of the folder build/deb."""
    number = release.version(re.search(r'CRN_VERSION "([0-9.]+)"', release.read("shared", "version.h")).group(1), date)
    module = build_module(build)
    folder = os.path.join(build, "deb", "cournand")
    stage(build, folder, number, date)
    os.umask(0o022)
    quiet = {"LC_ALL": "C.UTF-8", "TZ": "UTC", "DEB_RULES_REQUIRES_ROOT": "no", "MAKEFLAGS": "", "MAKELEVEL": ""}
    words = ["dpkg-architecture", "--command", "debian/rules binary"]  # it sets the names of the processor
    run(words, folder, CRN_BUILD=build, CRN_MODULE=module, SOURCE_DATE_EPOCH=str(date), **quiet)
    os.makedirs(output, exist_ok=True)
    for old in glob.glob(os.path.join(output, "*cournand*.deb")):
        os.remove(old)
    made = sorted(glob.glob(os.path.join(build, "deb", "*_%s_*.deb" % number)))
    return [shutil.move(path, os.path.join(output, os.path.basename(path))) for path in made]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="folder of the programs (default: build)")
    parser.add_argument("--output", default="out/deb", help="folder for the packages (default: out/deb)")
    options = parser.parse_args()
    try:
        for path in make(os.path.abspath(options.build), os.path.abspath(options.output)):
            print("%s  %.1f MB" % (os.path.relpath(path), os.path.getsize(path) / 1e6))
    except (Fault, OSError) as fault:
        sys.exit("make_packages: %s" % fault)


if __name__ == "__main__":
    main()
