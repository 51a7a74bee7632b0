"""Makes Python virtual environments with the packages of a requirements file, whose versions are fixed."""

import hashlib
import os
import shutil
import subprocess
import venv


class EnvironmentFault(Exception):
    """Reports that the virtual environment cannot be made; the exception's text states the remedy."""


class PackagesFault(Exception):
    """Reports that pip cannot install the packages; the exception's text is the output of pip. The caller knows the
    remedy."""


def python_of(folder):
    return os.path.join(folder, "bin", "python")


def make(folder, requirements, announce=lambda: None, with_debian=False):
    """Makes the environment, unless one with the same requirements exists, and returns the path of its Python. Calls
    `announce` before it downloads anything. With `with_debian`, the environment also sees the packages of the Python
    that calls this function."""
    stamp = os.path.join(folder, "requirements.sha256")
    with open(requirements, "rb") as file:
        wanted = hashlib.sha256(file.read()).hexdigest()
    if os.path.exists(stamp) and os.path.exists(python_of(folder)):
        with open(stamp, encoding="ascii") as file:
            if file.read() == wanted:
                return python_of(folder)
    announce()
    shutil.rmtree(folder, ignore_errors=True)
    try:
        venv.create(folder, with_pip=True, system_site_packages=with_debian)
    except (OSError, subprocess.CalledProcessError) as error:
        raise EnvironmentFault(
            "no virtual environment: %s. Remedy: sudo apt-get install python3-venv" % error
        ) from error
    words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "-r", requirements]
    ended = subprocess.run(
        [python_of(folder)] + words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if ended.returncode != 0:
        raise PackagesFault(ended.stdout)
    with open(stamp, "w", encoding="ascii") as file:
        file.write(wanted)
    return python_of(folder)
