#!/usr/bin/env python3
"""These tests check the following. Eight stations ship 48 sessions to one server at once; kills of stations and
server lose none and double none. This is the short form of test_thousand_sessions.py. Prints TAP."""

import stations

stations.run(8, 6, seed=7, kills={"stations": 5, "connections": 1, "servers": 2})
