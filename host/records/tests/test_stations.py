#!/usr/bin/env python3
"""Tests that eight stations can send 48 sessions to one server at once: although stations and server are killed, no
session is lost or stored twice. This test is the short form of test_thousand_sessions.py. Prints TAP."""

import stations

stations.run(8, 6, seed=7, kills={"stations": 5, "connections": 1, "servers": 2})
