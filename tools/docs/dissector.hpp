// The Wireshark dissector as Lua: tables of the one definition of the wire, then tools/docs/dissector.lua.
#pragma once
#include <string>

// The tables `records`, `messages`, `faults` and `rejects`.
std::string dissector_tables();
