// The Wireshark dissector as Lua: tables of the one definition of the wire, then tools/docs/dissector.lua.
#pragma once
#include <string>

// Returns the tables `records`, `messages`, `faults` and `rejects`.
std::string dissector_tables();
