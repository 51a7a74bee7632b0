"""Starts a separate PostgreSQL server in a temporary folder, for tests. The test's server has no network port: clients
use a socket in the server's folder."""

import glob
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time


class Server:
    def __init__(self):
        programs = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"))
        if not programs:
            raise SystemExit("Bail out! PostgreSQL's server is missing: apt-get install postgresql")
        self.programs = os.path.dirname(programs[-1])
        self.folder = tempfile.mkdtemp(prefix="cournand-pg-")
        self.data = os.path.join(self.folder, "data")
        self.url = "postgresql://cournand@/postgres?host=" + self.folder
        self.process = None
        self.as_user = []
        if os.geteuid() == 0:  # PostgreSQL refuses to run as root
            user = pwd.getpwnam("nobody")
            os.chown(self.folder, user.pw_uid, user.pw_gid)
            self.as_user = ["setpriv", "--reuid=nobody", "--regid=%d" % user.pw_gid, "--clear-groups"]
        self._run("initdb", "-D", self.data, "-A", "trust", "-U", "cournand", "-E", "UTF8", "--locale=C")
        self.start()

    def _run(self, program, *arguments):
        command = self.as_user + [os.path.join(self.programs, program), *arguments]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit("Bail out! %s: %s" % (program, done.stderr.strip()))

    def start(self):
        """Starts the server and waits until it answers. After SIGKILL the first attempts may fail, while the last
        processes of the old server still end."""
        for _ in range(100):
            command = [os.path.join(self.programs, "postgres"), "-D", self.data, "-k", self.folder, "-h", ""]
            log = open(os.path.join(self.folder, "log"), "a")
            self.process = subprocess.Popen(
                self.as_user + command, cwd=self.folder, stdout=log, stderr=log, start_new_session=True
            )
            log.close()
            while self.process.poll() is None:
                if self.answers():
                    return
                time.sleep(0.05)
            time.sleep(0.1)
        raise SystemExit(
            "Bail out! the server does not start: " + open(os.path.join(self.folder, "log")).read()[-2000:]
        )

    def answers(self):
        command = [os.path.join(self.programs, "pg_isready"), "-q", "-h", self.folder]
        return subprocess.run(command).returncode == 0

    def kill(self):
        """Ends the server's first process by SIGKILL; its other processes notice that and end without a word."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def backends(self):
        """Returns the process ids that serve connections."""
        found = []
        for stat in glob.glob("/proc/[0-9]*/stat"):
            try:
                parent = open(stat).read().rsplit(")", 1)[1].split()[1]
                words = open(os.path.dirname(stat) + "/cmdline").read()
            except OSError:
                continue
            if int(parent) == self.process.pid and "postgres: cournand" in words:
                found.append(int(os.path.basename(os.path.dirname(stat))))
        return found

    def query(self, statement):
        command = [os.path.join(self.programs, "psql"), "-X", "-q", "-A", "-t", "-v", "ON_ERROR_STOP=1", self.url]
        return subprocess.run(command + ["-c", statement], capture_output=True, text=True, check=True).stdout.strip()

    def stop(self):
        if self.process and self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
