#!/usr/bin/env python3
"""Installs the package's wheel in a bare Debian 12 that mmdebstrap makes. Besides Debian's minimal system, the bare
Debian has only python3 and python3-venv, and no network. A user without rights makes an empty virtual environment, and
the five lines of the README make a picture. The test needs the network to make the bare Debian, and prints the seconds
that the user waits. Prints TAP."""

import os
import shutil
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402
import wheel  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402

GIVEN = os.path.join(wheel.WORK, "given")
IN_THE_BARE_DEBIAN = """set -eu
useradd --create-home trainee
cat >/home/trainee/install.sh <<'S'
set -eu
cd
begin=$(date +%s)
python3 -m venv empty
empty/bin/pip install --quiet --no-index --find-links /given /given/cournand-*.whl
empty/bin/python /given/five_lines.py
echo "a picture after $(($(date +%s) - begin)) s"
S
runuser -u trainee -- bash /home/trainee/install.sh
cp /home/trainee/wire.png /given/
"""


def a_picture_in_a_bare_debian():
    wheels = wheel.downloaded()
    if not wheels:
        return False
    shutil.copytree(wheels, GIVEN)
    shutil.copy(wheel.found("complete/*.whl"), GIVEN)
    for name, text in (("five_lines.py", wheel.five_lines()), ("bare.sh", IN_THE_BARE_DEBIAN)):
        with open(os.path.join(GIVEN, name), "w", encoding="utf-8") as file:
            file.write(text)
    words = ["mmdebstrap", "--quiet", "--variant=minbase", "--include=python3,python3-venv"]
    words += ["--customize-hook=copy-in %s /" % GIVEN]
    run = "env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin unshare --net bash /given/bare.sh"  # no variable of this machine
    words += ['--customize-hook=chroot "$1" %s >"$1/given/said" 2>&1 || true' % run]
    words += ["--customize-hook=copy-out /given/said %s" % wheel.WORK]
    words += ['--customize-hook=cp "$1/given/wire.png" %s || true' % wheel.WORK]
    made = wheel.succeeds([*words, "bookworm", "/dev/null"])
    said = os.path.join(wheel.WORK, "said")
    if not made or not os.path.exists(said):
        return False
    with open(said, encoding="utf-8") as file:
        print("# " + file.read().strip().replace("\n", "\n# "))
    picture = os.path.join(wheel.WORK, "wire.png")
    if not os.path.exists(picture):
        return False
    with open(picture, "rb") as file:
        return file.read(8) == b"\x89PNG\r\n\x1a\n" and os.path.getsize(picture) > 1000


tap.run([wheel.pip_makes_a_wheel, wheel.auditwheel_completes_the_wheel, a_picture_in_a_bare_debian])
