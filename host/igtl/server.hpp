// Sends a session to programs such as 3D Slicer by OpenIGTLink (docs/slicer.md). A separate thread serves all
// clients. Publishing takes microseconds and never waits for a client: if a client is too slow, newer data
// replace the data that it has not received. All bytes that clients send are discarded.
//
//   const std::unique_ptr<IgtlServer> server = open_igtl({"127.0.0.1", 18944});
//   server->publish({{"CArm", {tick, pose}}});
#pragma once
#include "host/igtl/address.hpp"
#include "host/igtl/frame.hpp"
#include <chrono>
#include <memory>

namespace crn
{

class IgtlServer
{
  public:
    // The destructor waits for the time `linger`, so that the clients receive the remaining messages, and
    // then closes all connections.
    virtual ~IgtlServer() = default;
    virtual IgtlAddress address() const = 0; // with the port that the system has chosen
    virtual void publish(IgtlFrame frame) = 0;
    virtual std::size_t clients() const = 0;
};

struct IgtlLimits {
    std::size_t clients = 8;                 // a further client is closed at once
    std::chrono::milliseconds stall{30'000}; // a client that takes nothing for so long is closed
    std::chrono::milliseconds linger{500};   // at the end
};

// Throws UsageError if the program was built without OpenIGTLink, and std::runtime_error with the remedy if
// the address cannot be used.
std::unique_ptr<IgtlServer> open_igtl(const IgtlAddress &address, const IgtlLimits &limits = {});

} // namespace crn
