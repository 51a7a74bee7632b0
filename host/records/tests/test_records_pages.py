#!/usr/bin/env python3
"""Tests that the pages of a trainee and of a cohort open in Chromium without a network, and that charts, sentences and
tables agree with the records. Prints TAP."""

import html.parser
import os
import re
import shutil
import subprocess
import tempfile

from records_class import check


class Document(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.elements, self.open, self.words = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.open.append(tag)

    def handle_endtag(self, tag):
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data):
        if "style" not in self.open:
            self.words.append(data)

    def count(self, tag):
        return sum(name == tag for name, _ in self.elements)

    def text(self):
        return " ".join("".join(self.words).split())


def short(value):
    return ("%.1f" % value if value >= 10.0 else "%.2f" % value).rstrip("0").rstrip(".")


def open_page(path):
    """Returns the HTML document after Chromium has loaded it."""
    browser = shutil.which("chromium")
    assert browser, "chromium is missing: apt-get install chromium"
    with tempfile.TemporaryDirectory(prefix="cournand-chromium-") as profile:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
        command += ["--host-resolver-rules=MAP * ~NOTFOUND", "--user-data-dir=" + profile]  # no network
        command += ["--dump-dom", "file://" + path]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-800:]
    return Document(done.stdout)


def refers_outside(path):
    return re.search(r"(src|href)\s*=|url\(|<script|@import", open(path).read())


def the_page_of_a_trainee(desk):
    desk.fill()
    path = os.path.join(desk.folder, "t1.html")
    desk.run("curve", "t1", "--case", "lad_pci", "--metric", "score", "--metric", "fluoroscopy_min", "--html", path)
    curve = desk.json("curve", "t1", "--case", "lad_pci", "--metric", "fluoroscopy_min")["curves"][0]
    page = open_page(path)
    assert not refers_outside(path)
    assert page.count("circle") == 26 and page.count("polygon") == 4  # per chart: 13 sessions; own band, cohort's band
    charts = [attributes for tag, attributes in page.elements if tag == "svg" and attributes.get("role") == "img"]
    assert len(charts) == 3 and charts[0]["aria-label"] == "Score by session"  # the third is the CUSUM
    assert page.count("tr") == 14 and "moved_without_xray" in page.text()
    latest, now = curve["sessions"][-1]["value"], curve["fit"]["value"][-1]
    assert "latest %s min" % short(latest) in page.text() and "curve is now at %s min" % short(now) in page.text()
    assert "5 people had" in page.text() and "experts: median and range of 3 sessions" in page.text()
    assert "NaN" not in page.text() and not re.search(r"\bnan\b", open(path).read())


def the_page_of_a_cohort(desk):
    desk.fill()
    path = os.path.join(desk.folder, "cohort.html")
    desk.run("cohort", "--case", "lad_pci", "--html", path)
    page = open_page(path)
    assert not refers_outside(path)
    cohort = desk.json("cohort", "--case", "lad_pci")
    steps = sum(len(curve["cohort"]) for curve in cohort["curves"])
    assert page.count("svg") - page.count("figure") >= 3 and page.count("tr") == steps + 3
    assert "7 people" in page.text() and not re.search(r"\bt[0-6]\b", page.text())  # nobody is named


def hostile_names_stay_text(desk):
    name = '<img src=x onerror="alert(1)">&'
    event = {"tick": 1, "kind": "<i>kind", "severity": 1}
    made = [{"trainee": name, "case": "<b>case</b>", "duration_s": 1.0 + i, "events": [event]} for i in range(7)]
    for i, one in enumerate(made):
        one["started_at"] = "2026-10-01T00:00:0%d.000Z" % i
    desk.run("import", desk.write("x.json", {"format": 1, "sessions": made}))
    path = os.path.join(desk.folder, "x.html")
    desk.run("curve", name, "--case", "<b>case</b>", "--html", path)
    page = open_page(path)
    assert page.count("img") == page.count("i") == page.count("script") == 0
    assert name in page.text() and "<i>kind" in page.text()


check([the_page_of_a_trainee, the_page_of_a_cohort, hostile_names_stay_text])
