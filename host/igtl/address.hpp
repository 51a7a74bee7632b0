// Reads the address at which the OpenIGTLink server waits for clients.
#pragma once
#include <cstdint>
#include <string>

namespace crn
{

struct IgtlAddress {
    std::string host = "127.0.0.1"; // an address or a name of this machine
    std::uint16_t port = 0;         // 0: the system chooses a free port
    // Returns true if only programs on this machine can connect.
    bool is_local() const;
    std::string text() const; // HOST:PORT, with an IPv6 address in brackets
};

// Reads PORT, HOST:PORT or [IPV6]:PORT. Throws std::runtime_error with the reason and the remedy.
IgtlAddress parse_igtl_address(const std::string &text);

} // namespace crn
