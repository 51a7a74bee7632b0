#!/usr/bin/env python3
"""Tests that sessions of a station reach a PostgreSQL server only once, even if they are sent again. Erasing on one
side must erase on the other, names and passwords must never leave the station, and a server's records must be readable
like those in a file.
The test starts its own PostgreSQL server. Prints TAP."""

import json
import shutil

import postgres_server
from records_class import check

SERVER = postgres_server.Server()


def fresh():
    """Removes all tables from the test's database server, so that each test function begins with an empty server."""
    SERVER.query("DROP SCHEMA public CASCADE; CREATE SCHEMA public")


def ship(desk, place=None, code=0):
    return json.loads(desk.run("ship", "--to", SERVER.url, "--json", place=place or desk.file, code=code)[0])


def the_server_has_the_sessions_of_the_file(desk):
    fresh()
    desk.fill()
    report = ship(desk)
    assert (report["sent"], report["known"], report["waiting"]) == (95, 0, 0), report
    own, there = (json.loads(desk.run("export", "--format", "json", place=place)[0]) for place in (None, SERVER.url))
    assert own == there
    assert desk.json("curve", "t0", "--case", "lad_pci") == desk.json(
        "curve", "t0", "--case", "lad_pci", place=SERVER.url
    )


# The copy of the file still has the sessions in its outbox, as if the station had crashed before it noted the answer.
def a_repeated_shipment_is_recognised(desk):
    fresh()
    desk.fill()
    copy = desk.folder + "/copy.db"
    shutil.copy(desk.file, copy)
    assert ship(desk)["sent"] == 95
    report = ship(desk, copy)
    assert (report["sent"], report["known"], report["waiting"]) == (0, 95, 0), report
    assert SERVER.query("SELECT (SELECT count(*) FROM session), (SELECT count(*) FROM metric)") == "95|95"


def names_stay_at_the_station(desk):
    fresh()
    desk.fill()
    desk.run("trainee", "t1", "--name", "Ann Quicksilver")
    ship(desk)
    assert SERVER.query("SELECT count(*) FROM trainee_name") == "0"
    assert "never on a server" in desk.run("trainee", "t1", "--name", "Ann", place=SERVER.url, code=1)[1]


def erasing_reaches_the_server_and_the_other_stations(desk):
    fresh()
    desk.fill()
    other = desk.folder + "/other.db"
    desk.run("import", desk.folder + "/class.json", place=other)
    ship(desk)
    desk.run("erase", "t1", "--yes")
    ship(desk)
    assert SERVER.query("SELECT count(*) FROM session WHERE trainee_id NOT IN (SELECT id FROM trainee)") == "0"
    assert "t1" not in desk.run("list", "--trainees", place=SERVER.url)[0].split()
    report = ship(desk, other)
    assert report["erased_here"] == 13 and report["waiting"] == 0, report
    assert "t1" not in desk.run("list", "--trainees", place=other)[0].split()
    assert b"t1" not in [word for word in open(other, "rb").read().split(b"\0") if word == b"t1"]


def erasing_at_the_server_reaches_the_station(desk):
    fresh()
    desk.fill()
    ship(desk)
    desk.run("erase", "t2", "--yes", place=SERVER.url)
    assert ship(desk)["erased_here"] == 12
    assert "there is no trainee 't2'" in desk.run("show", "t2", code=1)[1]


def changes_of_a_trainee_reach_the_server(desk):
    fresh()
    desk.fill()
    ship(desk)
    desk.run("rename", "t3", "heron")
    desk.run("trainee", "heron", "--group", "fellows")
    ship(desk)
    found = {one["trainee"]: one for one in desk.json("list", "--trainees", place=SERVER.url)}
    assert "t3" not in found and found["heron"]["group"] == "fellows" and found["heron"]["sessions"] == 14


def a_session_that_the_server_refuses_is_named_and_waits(desk):
    fresh()
    desk.fill()
    ship(desk)
    SERVER.query("ALTER TABLE session ADD CHECK (case_id <> 'x')")
    made = [
        {"trainee": "t0", "case": name, "started_at": "2026-10-30T00:00:00.000Z", "duration_s": 1.0} for name in "xy"
    ]
    desk.run("import", desk.write("x.json", {"format": 1, "sessions": made}))
    report = ship(desk, code=1)
    assert report["sent"] == 1 and report["waiting"] == 1 and "check constraint" in report["refused"][0]
    SERVER.query("ALTER TABLE session DROP CONSTRAINT session_case_id_check")
    assert ship(desk)["sent"] == 1


def newer_tables_are_refused(desk):
    fresh()
    desk.run("list", place=SERVER.url)
    SERVER.query("UPDATE cournand_version SET version = 99")
    assert "update Cournand" in desk.run("list", place=SERVER.url, code=1)[1]


def an_absent_server_is_named_without_its_password(desk):
    desk.fill()
    url = "postgresql://anna:geheim@/postgres?host=" + desk.folder
    error = desk.run("ship", "--to", url, place=desk.file, code=1)[1]
    assert "cannot be reached" in error and "records ship" in error and "geheim" not in error
    assert desk.json("check")["waiting"] == 95


try:
    check([
        the_server_has_the_sessions_of_the_file,
        a_repeated_shipment_is_recognised,
        names_stay_at_the_station,
        erasing_reaches_the_server_and_the_other_stations,
        erasing_at_the_server_reaches_the_station,
        changes_of_a_trainee_reach_the_server,
        a_session_that_the_server_refuses_is_named_and_waits,
        newer_tables_are_refused,
        an_absent_server_is_named_without_its_password,
    ])  # fmt: skip
finally:
    SERVER.stop()
