#include "host/igtl/socket.hpp"
#include <cerrno>
#include <cstring>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdexcept>
#include <sys/socket.h>

namespace crn
{

namespace
{

constexpr int clients_waiting_max = 16;

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

[[noreturn]] void refuse(const IgtlAddress &address, const std::string &why, const std::string &remedy)
{
    throw std::runtime_error("--igtl: cannot wait for clients at " + address.text() + ": " + why +
                             ". Remedy: " + remedy);
}

Addresses find_addresses(const IgtlAddress &address)
{
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    addrinfo *found = nullptr;
    const int error = getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
    if (error != 0) refuse(address, gai_strerror(error), "name an address of this machine, or 127.0.0.1");
    return {found, &freeaddrinfo};
}

std::uint16_t port_of(int descriptor)
{
    sockaddr_storage own{};
    socklen_t size = sizeof own;
    getsockname(descriptor, reinterpret_cast<sockaddr *>(&own), &size);
    if (own.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6 &>(own).sin6_port);
    return ntohs(reinterpret_cast<const sockaddr_in &>(own).sin_port);
}

std::string remedy_of(int error)
{
    if (error == EADDRINUSE) return "end the program that uses this port, or name another port";
    if (error == EACCES) return "name a port of 1024 or above, such as 18944";
    return "name an address of this machine, or 127.0.0.1";
}

} // namespace

OwnedSocket listen_at(IgtlAddress &address)
{
    const Addresses found = find_addresses(address);
    int error = 0;
    for (const addrinfo *one = found.get(); one; one = one->ai_next) {
        OwnedSocket socket(
            ::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, one->ai_protocol));
        // Without this option, the port would stay reserved for a minute after a session has ended.
        const int yes = 1;
        setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        if (bind(socket.get(), one->ai_addr, one->ai_addrlen) == 0 &&
            listen(socket.get(), clients_waiting_max) == 0) {
            address.port = port_of(socket.get());
            return socket;
        }
        error = errno;
    }
    refuse(address, std::strerror(error), remedy_of(error));
}

int accept_at(int listener)
{
    const int socket = ::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    const int yes = 1;
    if (socket >= 0) setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    return socket;
}

} // namespace crn
