// Opens the sockets of the OpenIGTLink server.
#pragma once
#include "host/igtl/address.hpp"
#include "host/igtl/client.hpp"

namespace crn
{

// Returns a socket that accepts connections. If the port in `address` is 0, the function stores the port
// there that the system has chosen. Throws std::runtime_error with the remedy.
OwnedSocket listen_at(IgtlAddress &address);

// Returns the descriptor of the next client's socket, or -1.
int accept_at(int listener);

} // namespace crn
