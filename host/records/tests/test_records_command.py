#!/usr/bin/env python3
"""Tests that `cournand records` lists, shows, exports, imports, renames and erases. The exported xAPI statements must
follow the Experience API 1.0.3, and wrong requests must be refused with a remedy and the right exit code. Prints
TAP."""

import csv
import hashlib
import io
import json
import os
import re
import sqlite3

from records_class import check

UUID = re.compile(r"^[0-9a-f]{8}-[0-9a-f]{4}-[1-5][0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$")
IRI = re.compile(r"^[a-z][a-z0-9+.-]*://[^\s<>\"{}|\\^`]+$")
DURATION = re.compile(r"^P(?=.)(\d+D)?(T(?=.)(\d+H)?(\d+M)?(\d+(\.\d{1,2})?S)?)?$")  # ISO 8601, 0.01 s as xAPI asks
TIMESTAMP = re.compile(r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$")
MEMBERS = {"id", "actor", "verb", "object", "result", "context", "timestamp"}


def lists_sessions_and_trainees(desk):
    desk.fill()
    assert len(desk.json("list")["sessions"]) == 95
    assert len(desk.json("list", "--trainee", "t3")["sessions"]) == 14
    text = desk.run("list", "--trainee", "t3")[0]
    assert "14 sessions" in text and "lad_pci" in text
    trainees = {one["trainee"]: one for one in desk.json("list", "--trainees")}
    assert trainees["t3"]["sessions"] == 14 and trainees["expert"]["is_expert"] and not trainees["t3"]["is_expert"]


def shows_one_session_and_one_trainee(desk):
    desk.fill()
    one = desk.json("list", "--trainee", "t0")["sessions"][0]
    assert desk.json("show", one["id"][:13]) == one
    text = desk.run("show", one["id"])[0]
    assert "fluoroscopy_min" in text and "moved_without_xray" in text and "err 3" in text
    assert len(desk.json("show", "t0")["records"]) == 14


def an_export_is_imported_unchanged_and_only_once(desk):
    desk.fill()
    text = desk.run("export", "--format", "json")[0]
    copy = desk.write("copy.json", text)
    other = os.path.join(desk.folder, "other.db")
    assert "95 sessions imported, 0 known" in desk.run("import", copy, place=other)[0]
    assert "0 sessions imported, 95 known" in desk.run("import", copy, place=other)[0]
    own, there = json.loads(text)["sessions"], json.loads(desk.run("export", "--format", "json", place=other)[0])
    for session in own + there["sessions"]:
        del session["station"]  # the importing station answers for it
    assert own == there["sessions"]


def csv_has_one_line_per_session(desk):
    desk.fill()
    rows = list(csv.DictReader(io.StringIO(desk.run("export", "--trainee", "t1")[0], newline="")))
    sessions = desk.json("list", "--trainee", "t1")["sessions"]
    assert len(rows) == len(sessions) == 13
    for row, session in zip(rows, sessions):
        assert row["session"] == session["id"] and row["trainee"] == "t1"
        assert abs(float(row["score"]) - session["score"]["total"]) < 1e-9
        assert int(row["errors"]) == len(session["events"])
        assert abs(float(row["metric fluoroscopy_min"]) - session["metrics"][0]["value"]) < 1e-9


def xapi_statements_follow_the_rules(desk):
    desk.fill()
    command = ["export", "--format", "xapi", "--home-page", "https://hospital.example"]
    statements = json.loads(desk.run(*command)[0])
    assert len(statements) == len({one["id"] for one in statements}) == 95
    sessions = desk.json("list")["sessions"]
    for one, session in zip(statements, sessions):
        assert set(one) <= MEMBERS and {"actor", "verb", "object"} <= set(one)
        assert UUID.match(one["id"]) and UUID.match(one["context"]["registration"])
        assert one["actor"] == {"objectType": "Agent", "account": {
            "homePage": "https://hospital.example", "name": session["trainee"]}}  # fmt: skip
        assert one["verb"]["id"] == "http://adlnet.gov/expapi/verbs/" + ("passed" if session["passed"] else "failed")
        assert one["object"]["objectType"] == "Activity" and IRI.match(one["object"]["id"])
        assert IRI.match(one["object"]["definition"]["type"]) and TIMESTAMP.match(one["timestamp"])
        result, score = one["result"], one["result"]["score"]
        assert DURATION.match(result["duration"]) and result["success"] == session["passed"]
        assert -1.0 <= score["scaled"] <= 1.0 and score["min"] <= score["raw"] <= score["max"]
        assert abs(score["scaled"] - session["score"]["total"] / 100.0) < 1e-12
        for part in (result, one["context"]):
            assert all(IRI.match(key) for key in part["extensions"])
    assert json.loads(desk.run(*command)[0]) == statements  # a store recognises what is sent again


def a_score_outside_its_range_is_a_valid_statement(desk):
    session = {"trainee": "t", "case": "å case/1", "started_at": "2026-10-01T00:00:00.000Z", "duration_s": 1.005,
               "score": {"total": -250.0, "of": 100.0}}  # fmt: skip
    desk.run("import", desk.write("x.json", {"format": 1, "sessions": [session]}))
    one = json.loads(desk.run("export", "--format", "xapi")[0])[0]
    assert one["result"]["score"] == {"scaled": -1.0, "raw": -250.0, "max": 100.0}
    assert one["verb"]["id"].endswith("/completed") and "success" not in one["result"]
    assert DURATION.match(one["result"]["duration"]) and IRI.match(one["object"]["id"])
    assert one["object"]["id"].isascii() and "/case/%c3%a5%20case%2f1" in one["object"]["id"]


def a_name_is_optional_and_never_exported(desk):
    desk.fill()
    desk.run("trainee", "t2", "--name", "Ann Quicksilver", "--group", "fellows", "--keep-until", "2020-12-31")
    assert "Ann Quicksilver" in desk.run("list", "--trainees")[0]
    for form in ("csv", "json", "xapi"):
        assert "Quicksilver" not in desk.run("export", "--format", form)[0]
    assert "1 trainee is past" in desk.run("list")[1]
    desk.run("trainee", "t2", "--no-name", "--no-keep-until")
    assert b"Quicksilver" not in open(desk.file, "rb").read() and desk.run("list")[1] == ""


def erasing_asks_and_deletes_only_own_recordings(desk):
    made = []
    for name in ("own", "changed", "link"):
        path = desk.write(name + ".rec", name)
        made.append({"trainee": "zebrafinch", "case": "a", "started_at": "2026-10-01T00:00:0%d.000Z" % len(made),
                     "duration_s": 1.0, "recording_path": path,
                     "recording_sha256": hashlib.sha256(name.encode()).hexdigest()})  # fmt: skip
    desk.run("import", desk.write("x.json", {"format": 1, "sessions": made}))
    os.remove(os.path.join(desk.folder, "x.json"))
    desk.write("changed.rec", "something else")
    os.rename(os.path.join(desk.folder, "link.rec"), os.path.join(desk.folder, "target"))
    os.symlink("target", os.path.join(desk.folder, "link.rec"))
    assert "nothing was changed" in desk.run("erase", "zebrafinch", code=1)[1]  # nobody answers the question
    assert "--keep-recordings" in desk.run("erase", "zebrafinch", "--yes", code=2)[1]
    assert len(desk.json("list")["sessions"]) == 3
    text = desk.run("erase", "zebrafinch", "--yes", "--recordings", code=1)[0]  # not all could be deleted
    assert "own.rec: deleted" in text and "changed.rec: kept" in text and "link.rec: kept" in text
    assert not os.path.exists(os.path.join(desk.folder, "own.rec"))
    assert os.path.exists(os.path.join(desk.folder, "target"))
    for name in os.listdir(desk.folder):
        if name.startswith("records.db"):
            assert b"zebrafinch" not in open(os.path.join(desk.folder, name), "rb").read()


def expired_trainees_are_erased_together(desk):
    desk.fill()
    for name in ("t1", "t2"):
        desk.run("trainee", name, "--keep-until", "2020-01-01")
    assert "no trainee is past" not in desk.run("erase", "--expired", "--yes")[0]
    assert not {"t1", "t2"} & {one["trainee"] for one in desk.json("list", "--trainees")}
    assert "no trainee is past" in desk.run("erase", "--expired", "--yes")[0]


def a_pseudonym_can_change(desk):
    desk.fill()
    desk.run("rename", "t1", "heron")
    assert len(desk.json("list", "--trainee", "heron")["sessions"]) == 13
    assert "t1" not in desk.run("list")[0]
    assert "already" in desk.run("rename", "heron", "t2", code=1)[1]


def check_finds_damage_and_missing_recordings(desk):
    desk.fill()
    assert desk.json("check")["faults"] == []
    database = sqlite3.connect(desk.file)
    database.execute("PRAGMA foreign_keys=OFF")
    database.execute("INSERT INTO metric VALUES ('nobody', 0, 'x', 1.0, '')")
    database.execute("UPDATE session SET recording_path = 'no.rec', recording_sha256 = '%s' "
                     "WHERE id = (SELECT min(id) FROM session)" % ("0" * 64))  # fmt: skip
    database.commit()
    database.close()
    report = json.loads(desk.run("check", "--json", code=1)[0])
    assert "'metric' refers to a missing row" in report["faults"][0]
    assert report["recordings"][0]["state"] == "missing"


def the_default_place_is_private(desk):
    environment = desk.environment
    for variable, folder in (("HOME", ".local/share"), ("XDG_DATA_HOME", "data")):
        environment[variable] = desk.folder if variable == "HOME" else os.path.join(desk.folder, folder)
        desk.place = os.path.join(desk.folder, folder, "cournand/records.db")
        import subprocess

        from records_class import PROGRAM

        done = subprocess.run([PROGRAM, "records", "list"], env=environment, capture_output=True, text=True)
        assert done.returncode == 0 and "0 sessions" in done.stdout, done.stderr
        assert os.stat(desk.place).st_mode & 0o777 == 0o600
        assert os.stat(os.path.dirname(desk.place)).st_mode & 0o777 == 0o700


def wrong_requests_are_refused_with_a_remedy(desk):
    desk.fill()
    assert "did you mean 'lad_pci'" in desk.run("curve", "t0", "--case", "lad_pic", code=1)[1]
    assert "did you mean 'fluoroscopy_min'" in desk.run(
        "curve", "t0", "--case", "lad_pci", "--metric", "fluoroscopy_mn", code=1)[1]  # fmt: skip
    assert "did you mean 't0'" in desk.run("show", "to", code=1)[1]
    assert "below" in desk.run("curve", "t0", "--case", "lad_pci", "--rate-good", "0.5", code=2)[1]
    assert "cannot be written" in desk.run("curve", "t0", "--case", "lad_pci", "--html", "no/x.html", code=1)[1]
    assert "cannot be written" in desk.run("export", "-o", "no/x.csv", code=1)[1]
    assert "--to or COURNAND_RECORDS" in desk.run("ship", code=2)[1]
    assert "this is not a file of sessions" in desk.run("import", desk.write("x.json", "[1]"), code=1)[1]
    desk.run("export", "--format", "pdf", code=2)
    desk.run("erase", code=2)
    assert len(desk.json("list")["sessions"]) == 95


def curve_and_cohort_as_json(desk):
    desk.fill()
    curve = desk.json("curve", "t0", "--case", "lad_pci", "--metric", "fluoroscopy_min")
    one = curve["curves"][0]
    assert len(one["sessions"]) == len(one["fit"]["value"]) == 14 and one["unit"] == "min"
    assert all(
        low <= value <= high for low, value, high in zip(one["fit"]["low"], one["fit"]["value"], one["fit"]["high"])
    )
    assert one["fit"]["gain"] > 5.0 and one["expert"]["sessions"] == 3 and one["cohort"][0]["people"] == 7
    assert desk.json("curve", "t0", "--case", "lad_pci", "--metric", "fluoroscopy_min") == curve
    cohort = desk.json("cohort", "--case", "lad_pci")
    assert cohort["people"] == 7 and min(step["people"] for step in cohort["curves"][0]["cohort"]) >= 5
    for name in ("t0", "t1", "t2", "t3"):
        desk.run("trainee", name, "--group", "fellows")
    assert "only 4 people" in desk.run("cohort", "--case", "lad_pci", "--group", "fellows", code=1)[1]


check([
    lists_sessions_and_trainees,
    shows_one_session_and_one_trainee,
    an_export_is_imported_unchanged_and_only_once,
    csv_has_one_line_per_session,
    xapi_statements_follow_the_rules,
    a_score_outside_its_range_is_a_valid_statement,
    a_name_is_optional_and_never_exported,
    erasing_asks_and_deletes_only_own_recordings,
    expired_trainees_are_erased_together,
    a_pseudonym_can_change,
    check_finds_damage_and_missing_recordings,
    the_default_place_is_private,
    wrong_requests_are_refused_with_a_remedy,
    curve_and_cohort_as_json,
])  # fmt: skip
