#!/usr/bin/env python3
"""Claims: eight stations ship 1,000 sessions to one server at once; kills of stations, connections and server lose
none and double none. Prints TAP."""

import stations

stations.run(8, 125, seed=11, pause_s=1.0, least={"stations": 10, "connections": 3, "servers": 3}, most=60)
