// Writes the Wireshark dissector in Lua: tables made from the wire's definition, followed by
// tools/docs/dissector.lua.
#pragma once
#include <string>

// Returns the Lua tables `records`, `messages`, `faults` and `rejects`.
std::string dissector_tables();
