// Holds the connection to one OpenIGTLink client, with the messages that wait to be sent and the number of
// bytes sent. It never blocks. Only the server's thread uses the sockets.
#pragma once
#include "host/igtl/outbox.hpp"
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace crn
{

using IgtlBytes = std::shared_ptr<const std::vector<std::uint8_t>>; // one message, shared by all clients

// Owns a file descriptor.
class OwnedSocket
{
  public:
    explicit OwnedSocket(int descriptor = -1) : descriptor_(descriptor) {}
    ~OwnedSocket();
    OwnedSocket(OwnedSocket &&other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    OwnedSocket &operator=(OwnedSocket &&other) noexcept
    {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    int get() const { return descriptor_; }

  private:
    int descriptor_;
};

class IgtlClient
{
  public:
    using Clock = std::chrono::steady_clock;
    // A client may send at most this many bytes per round of the server's loop, so that no client keeps the
    // server busy.
    static constexpr std::size_t read_max = 65536;

    explicit IgtlClient(OwnedSocket socket) : socket_(std::move(socket)) {}

    int descriptor() const { return socket_.get(); }
    void give(Outbox<IgtlBytes>::Moment moment);
    bool has_unsent() const { return at_ < sending_.size() || !waiting_.is_empty(); }
    // Sends as many bytes as the connection accepts at present. Returns false if the connection has ended.
    bool send();
    // Reads and discards what the client has sent. Returns false if the connection has ended.
    bool discard();
    bool has_sent_much() const { return has_sent_much_; } // in the last call of discard()
    // Returns for how long the client has accepted no bytes, although messages wait.
    Clock::duration stalled(Clock::time_point now) const;

  private:
    bool send_one();

    OwnedSocket socket_;
    Outbox<IgtlBytes> waiting_;
    std::vector<IgtlBytes> sending_;      // the messages of one moment
    std::size_t at_ = 0, sent_bytes_ = 0; // the message that is being sent, and its bytes that were sent
    bool has_sent_much_ = false;
    Clock::time_point progressed_ = Clock::now();
};

} // namespace crn
