// Writes the Wireshark dissector in Lua. The dissector consists of tables made from the definition of the
// wire protocol, followed by tools/docs/dissector.lua.
#pragma once
#include <string>

// Returns the text of the Lua tables `records`, `messages`, `faults` and `rejects`.
std::string dissector_tables();
