// Serves OpenIGTLink clients in its own thread. The session's thread only puts new data into the inbox.
#include "host/igtl/server.hpp"
#include "host/base/terminal.hpp"
#include "host/igtl/client.hpp"
#include "host/igtl/pack.hpp"
#include "host/igtl/socket.hpp"
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <list>
#include <mutex>
#include <poll.h>
#include <sys/eventfd.h>
#include <thread>
#include <unistd.h>

namespace crn
{

namespace
{

using Clock = IgtlClient::Clock;
constexpr int rest_ms = 10;  // before the next bytes of a client that sends much, or after a failed accept
constexpr int look_ms = 500; // between two looks for clients that take nothing

class ThreadedServer final : public IgtlServer
{
  public:
    ThreadedServer(const IgtlAddress &address, const IgtlLimits &limits)
        : limits_(limits), address_(address), listener_(listen_at(address_)),
          bell_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)), thread_([this] { run(); })
    {
    }
    ~ThreadedServer() override
    {
        {
            const std::lock_guard lock(mutex_);
            must_end_ = true;
        }
        ring();
        thread_.join();
    }

    IgtlAddress address() const override { return address_; }
    std::size_t clients() const override { return client_count_; }
    void publish(IgtlFrame frame) override
    {
        {
            const std::lock_guard lock(mutex_);
            inbox_.push(std::move(frame));
        }
        ring();
    }

  private:
    void ring()
    {
        const std::uint64_t one = 1;
        [[maybe_unused]] const ssize_t count = ::write(bell_.get(), &one, sizeof one);
    }
    // If no memory is left, the server stops, and the session continues.
    void run()
    {
        try {
            while (take_inbox()) round(Clock::duration::max());
            const Clock::time_point end = Clock::now() + limits_.linger;
            const auto has_unsent = [](const IgtlClient &client) { return client.has_unsent(); };
            while (Clock::now() < end && std::any_of(clients_.begin(), clients_.end(), has_unsent))
                round(end - Clock::now());
        } catch (const std::exception &error) {
            say(stderr, "cournand: --igtl: the session goes on without its server: %s\n", error.what());
        }
        clients_.clear();
        client_count_ = 0;
    }

    bool take_inbox();
    void remember(const IgtlFrame &frame);
    Outbox<IgtlBytes>::Moment packed(const IgtlFrame &frame) const;
    void round(Clock::duration longest);
    int pause_ms(Clock::duration longest) const;
    void accept_client();
    bool serve(IgtlClient &client, short events);

    const IgtlLimits limits_;
    IgtlAddress address_;
    OwnedSocket listener_, bell_;
    std::list<IgtlClient> clients_;
    std::atomic<std::size_t> client_count_ = 0;
    IgtlFrame latest_; // for a client that comes now
    bool rests_ = false;

    std::mutex mutex_;
    Outbox<IgtlItem> inbox_;
    bool must_end_ = false;
    std::thread thread_; // the last member, because it uses the others
};

// Passes the published data on to the clients. Returns false at the end.
bool ThreadedServer::take_inbox()
{
    for (;;) {
        IgtlFrame frame;
        {
            const std::lock_guard lock(mutex_);
            if (inbox_.is_empty()) return !must_end_;
            frame = inbox_.pop();
        }
        remember(frame);
        if (clients_.empty()) continue;
        const Outbox<IgtlBytes>::Moment moment = packed(frame);
        for (IgtlClient &client : clients_) client.give(moment);
    }
}

// The pose of a tool that has left the patient is removed.
void ThreadedServer::remember(const IgtlFrame &frame)
{
    const auto is_pose = [](const auto &entry) {
        return std::holds_alternative<IgtlPose>(entry.second.content);
    };
    if (std::any_of(frame.begin(), frame.end(), is_pose)) std::erase_if(latest_, is_pose);
    for (const auto &[name, item] : frame) latest_.insert_or_assign(name, item);
}

Outbox<IgtlBytes>::Moment ThreadedServer::packed(const IgtlFrame &frame) const
{
    Outbox<IgtlBytes>::Moment moment;
    for (const auto &[name, item] : frame)
        moment.emplace(name, std::make_shared<const std::vector<std::uint8_t>>(pack_igtl(name, item)));
    return moment;
}

int ThreadedServer::pause_ms(Clock::duration longest) const
{
    const auto has_unsent = [](const IgtlClient &client) { return client.has_unsent(); };
    const bool waits = std::any_of(clients_.begin(), clients_.end(), has_unsent);
    if (!waits && !rests_ && longest == Clock::duration::max()) return -1;
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(std::min<Clock::duration>(longest, limits_.stall));
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, rests_ ? rest_ms : look_ms));
}

// Waits for the next event of the server, and handles it.
void ThreadedServer::round(Clock::duration longest)
{
    const auto wanted = [](int descriptor, bool reads, bool writes) {
        return pollfd{descriptor, static_cast<short>((reads ? POLLIN : 0) | (writes ? POLLOUT : 0)), 0};
    };
    std::vector<pollfd> polled{wanted(bell_.get(), true, false), wanted(listener_.get(), !rests_, false)};
    for (const IgtlClient &client : clients_)
        polled.push_back(
            wanted(client.descriptor(), !(rests_ && client.has_sent_much()), client.has_unsent()));
    ::poll(polled.data(), polled.size(), pause_ms(longest));
    rests_ = false;
    std::uint64_t rings = 0;
    [[maybe_unused]] const ssize_t count = ::read(bell_.get(), &rings, sizeof rings);
    std::size_t at = 2;
    for (auto client = clients_.begin(); client != clients_.end();)
        client = serve(*client, polled[at++].revents) ? std::next(client) : clients_.erase(client);
    if (polled[1].revents) accept_client();
    client_count_ = clients_.size();
}

bool ThreadedServer::serve(IgtlClient &client, short events)
{
    if (events & (POLLIN | POLLERR | POLLHUP)) {
        if (!client.discard()) return false;
        rests_ = rests_ || client.has_sent_much();
    }
    if (!client.send()) return false;
    return client.stalled(Clock::now()) < limits_.stall;
}

void ThreadedServer::accept_client()
{
    OwnedSocket socket(accept_at(listener_.get()));
    if (socket.get() < 0) {
        rests_ = true; // too many open files, for example
        return;
    }
    if (clients_.size() >= limits_.clients) return;
    take_inbox(); // what was published before the client came belongs to the present state
    clients_.emplace_back(std::move(socket));
    if (!latest_.empty()) clients_.back().give(packed(latest_));
}

} // namespace

std::unique_ptr<IgtlServer> open_igtl(const IgtlAddress &address, const IgtlLimits &limits)
{
    return std::make_unique<ThreadedServer>(address, limits);
}

} // namespace crn
