#!/usr/bin/env python3
"""These tests check the following. Eight stations ship 1,000 sessions to one server at once; kills of stations,
connections and server lose none and double none. Prints TAP."""

import stations

stations.run(8, 125, seed=11, kills={"stations": 30, "connections": 10, "servers": 10})
