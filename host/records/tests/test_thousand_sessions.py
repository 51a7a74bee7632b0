#!/usr/bin/env python3
"""Tests that eight stations can send 1,000 sessions to one server at once: although stations, connections and server
are killed, no session is lost or stored twice. Prints TAP."""

import stations

stations.run(8, 125, seed=11, kills={"stations": 30, "connections": 10, "servers": 10})
