#include "host/igtl/client.hpp"
#include <array>
#include <cerrno>
#include <sys/socket.h>
#include <unistd.h>

namespace crn
{

namespace
{

bool is_only_busy()
{
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

} // namespace

OwnedSocket::~OwnedSocket()
{
    if (descriptor_ >= 0) ::close(descriptor_);
}

void IgtlClient::give(Outbox<IgtlBytes>::Moment moment)
{
    if (!has_unsent()) progressed_ = Clock::now();
    waiting_.push(std::move(moment));
}

IgtlClient::Clock::duration IgtlClient::stalled(Clock::time_point now) const
{
    return has_unsent() ? now - progressed_ : Clock::duration::zero();
}

bool IgtlClient::send()
{
    while (has_unsent()) {
        if (at_ == sending_.size()) {
            sending_.clear();
            at_ = 0;
            for (auto &[name, bytes] : waiting_.pop()) sending_.push_back(std::move(bytes));
            continue;
        }
        if (!send_one()) return is_only_busy();
    }
    return true;
}

// Sends a part of the present message. Returns false, with the reason in errno, if the connection accepts no
// bytes at present.
bool IgtlClient::send_one()
{
    const std::vector<std::uint8_t> &bytes = *sending_[at_];
    const ssize_t count = ::send(descriptor(), bytes.data() + sent_bytes_, bytes.size() - sent_bytes_,
                                 MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0) return false;
    progressed_ = Clock::now();
    sent_bytes_ += static_cast<std::size_t>(count);
    if (sent_bytes_ < bytes.size()) return true;
    ++at_;
    sent_bytes_ = 0;
    return true;
}

bool IgtlClient::discard()
{
    std::array<char, 4096> bytes;
    std::size_t total = 0;
    has_sent_much_ = false;
    while (total < read_max) {
        const ssize_t count = ::recv(descriptor(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (count == 0) return false;
        if (count < 0) return is_only_busy();
        total += static_cast<std::size_t>(count);
    }
    has_sent_much_ = true;
    return true;
}

} // namespace crn
