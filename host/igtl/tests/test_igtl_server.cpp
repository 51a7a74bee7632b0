// These tests check the following. Clients made with libOpenIGTLink receive poses, pictures and the status.
// Clients that are slow, disconnected, too many or send random bytes disturb neither the session nor other
// clients.
#include "host/igtl/server.hpp"
#include <arpa/inet.h>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstring>
#include <functional>
#include <netinet/in.h>
#include <openigtlink/igtlClientSocket.h>
#include <openigtlink/igtlImageMessage.h>
#include <openigtlink/igtlMessageHeader.h>
#include <openigtlink/igtlStatusMessage.h>
#include <openigtlink/igtlTransformMessage.h>
#include <optional>
#include <random>
#include <stdexcept>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using std::chrono::milliseconds;

namespace
{

constexpr int patience_ms = 20'000; // a client that waits longer has found an error

// Holds a client that uses the same library as 3D Slicer.
class Client
{
  public:
    explicit Client(const IgtlServer &server) : socket_(igtl::ClientSocket::New())
    {
        assert_int_equal(socket_->ConnectToServer("127.0.0.1", server.address().port), 0);
        socket_->SetTimeout(patience_ms);
    }
    // Reads the next message, and returns its header, or nothing if the connection has ended.
    bool next()
    {
        header_ = igtl::MessageHeader::New();
        header_->InitPack();
        if (!read(header_->GetPackPointer(), header_->GetPackSize())) return false;
        header_->Unpack();
        return true;
    }
    std::string type() { return header_->GetDeviceType(); }
    std::string name() { return header_->GetDeviceName(); }
    void pass_over()
    {
        std::vector<char> body(static_cast<std::size_t>(header_->GetBodySizeToRead()));
        assert_true(read(body.data(), static_cast<int>(body.size())));
    }
    template <class Message> typename Message::Pointer body()
    {
        const typename Message::Pointer message = Message::New();
        message->SetMessageHeader(header_);
        message->AllocatePack();
        assert_true(read(message->GetPackBodyPointer(), message->GetPackBodySize()));
        assert_true(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY);
        return message;
    }
    // Returns the next message of this type, and skips all others.
    template <class Message> typename Message::Pointer wait_for(const std::string &wanted)
    {
        for (;;) {
            if (!next()) fail_msg("the connection ended before a message of type %s", wanted.c_str());
            if (type() == wanted) return body<Message>();
            pass_over();
        }
    }

  private:
    bool read(void *bytes, int count)
    {
        char *at = static_cast<char *>(bytes);
        while (count > 0) {
            const int got = socket_->Receive(at, count);
            if (got <= 0) return false;
            at += got;
            count -= got;
        }
        return true;
    }

    igtl::ClientSocket::Pointer socket_;
    igtl::MessageHeader::Pointer header_;
};

// A connection without any rule.
class RawClient
{
  public:
    explicit RawClient(const IgtlServer &server, int receive_bytes = 0)
        : socket_(::socket(AF_INET, SOCK_STREAM, 0))
    {
        if (receive_bytes > 0)
            setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(server.address().port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        assert_int_equal(::connect(socket_, reinterpret_cast<sockaddr *>(&address), sizeof address), 0);
    }
    ~RawClient() { ::close(socket_); }
    RawClient(const RawClient &) = delete;
    void send(const std::string &bytes) { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
    bool is_closed_by_server()
    {
        char byte = 0;
        return ::recv(socket_, &byte, 1, 0) <= 0;
    }
    // The connection ends without a closing handshake, as after a power failure.
    void reset()
    {
        const linger hard{1, 0};
        setsockopt(socket_, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
    }

  private:
    int socket_;
};

std::unique_ptr<IgtlServer> open(const IgtlLimits &limits = {})
{
    return open_igtl({"127.0.0.1", 0}, limits);
}

void wait_until(const std::function<bool()> &is_true)
{
    for (int waited = 0; !is_true(); ++waited) {
        if (waited > patience_ms) fail_msg("waited too long");
        std::this_thread::sleep_for(milliseconds(1));
    }
}

IgtlPose pose_at(double mm)
{
    IgtlPose pose = IgtlPose::Identity();
    pose.translation() = Eigen::Vector3d(mm, 2.0 * mm, 3.0 * mm);
    return pose;
}

IgtlPicture picture_of(int size, std::uint8_t value)
{
    IgtlPicture picture;
    picture.size = size;
    picture.grey =
        std::make_shared<const std::vector<std::uint8_t>>(static_cast<std::size_t>(size) * size, value);
    return picture;
}

IgtlFrame moment(std::uint32_t tick)
{
    return {{"Tool1Tip", {tick, pose_at(tick)}},
            {"Fluoroscopy", {tick, picture_of(64, static_cast<std::uint8_t>(tick))}},
            {"Cournand", {tick, IgtlStatus{true, "tick " + std::to_string(tick)}}}};
}

void assert_receives(Client &client, std::uint32_t tick)
{
    const auto status = client.wait_for<igtl::StatusMessage>("STATUS");
    assert_int_equal(status->GetSubCode(), tick);
    assert_int_equal(status->GetCode(), igtl::StatusMessage::STATUS_OK);
    assert_string_equal(status->GetStatusString(), ("tick " + std::to_string(tick)).c_str());
    const auto image = client.wait_for<igtl::ImageMessage>("IMAGE");
    assert_int_equal(static_cast<std::uint8_t *>(image->GetScalarPointer())[63],
                     static_cast<std::uint8_t>(tick));
    const auto transform = client.wait_for<igtl::TransformMessage>("TRANSFORM");
    float position[3];
    transform->GetPosition(position);
    assert_true(position[2] == 3.0f * static_cast<float>(tick));
}

void a_client_of_libopenigtlink_receives_status_picture_and_pose(void **)
{
    const auto server = open();
    Client client(*server);
    wait_until([&] { return server->clients() == 1; });
    for (std::uint32_t tick = 1; tick <= 3; ++tick) {
        server->publish(moment(tick));
        assert_receives(client, tick);
    }
}

void a_client_that_comes_later_receives_the_present_state(void **)
{
    const auto server = open();
    server->publish(moment(7));
    server->publish({{"Tool2Tip", {8, pose_at(8)}}}); // the first tool has left the patient
    Client first(*server);
    wait_until([&] { return server->clients() == 1; });
    server->publish({{"Tool3Tip", {9, pose_at(9)}}});
    std::vector<std::string> names;
    while (names.empty() || names.back() != "Tool3Tip") {
        assert_true(first.next());
        names.push_back(first.name());
        first.pass_over();
    }
    assert_true((names == std::vector<std::string>{"Cournand", "Fluoroscopy", "Tool2Tip", "Tool3Tip"}));
}

void two_clients_receive_the_same(void **)
{
    const auto server = open();
    Client first(*server), second(*server);
    wait_until([&] { return server->clients() == 2; });
    server->publish(moment(5));
    assert_receives(first, 5);
    assert_receives(second, 5);
}

// If the server could block, publish() would never return here.
void a_client_that_reads_nothing_stops_neither_the_session_nor_another_client(void **)
{
    IgtlLimits limits;
    limits.linger = milliseconds(10); // the dead client takes nothing at the end either
    const auto server = open(limits);
    RawClient dead(*server, 4096);
    Client alive(*server);
    wait_until([&] { return server->clients() == 2; });
    for (std::uint32_t tick = 1; tick <= 30; ++tick) {
        server->publish({{"Fluoroscopy", {tick, picture_of(1024, 1)}}});
        assert_string_equal(alive.wait_for<igtl::ImageMessage>("IMAGE")->GetDeviceName(), "Fluoroscopy");
    }
    assert_int_equal(server->clients(), 2);
}

// A slow client loses only old data: it still receives the last picture completely.
void a_slow_client_receives_the_newest_picture_in_the_end(void **)
{
    const auto server = open();
    Client slow(*server);
    wait_until([&] { return server->clients() == 1; });
    for (std::uint32_t tick = 1; tick <= 60; ++tick)
        server->publish({{"Fluoroscopy", {tick, picture_of(1024, static_cast<std::uint8_t>(tick))}}});
    for (std::uint32_t tick = 61; tick <= 100; ++tick) server->publish({{"CArm", {tick, pose_at(tick)}}});
    int pictures = 0, last = 0;
    while (last != 60) {
        const auto image = slow.wait_for<igtl::ImageMessage>("IMAGE");
        const int value = static_cast<std::uint8_t *>(image->GetScalarPointer())[0];
        assert_true(value > last);
        last = value;
        ++pictures;
    }
    assert_true(pictures < 60);
}

std::string header_with(const char *type, std::uint64_t body_bytes)
{
    const igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
    message->SetDeviceName("evil");
    message->Pack();
    std::string bytes(static_cast<const char *>(message->GetPackPointer()), 58);
    std::memset(bytes.data() + 2, 0, 12);
    std::memcpy(bytes.data() + 2, type, std::strlen(type));
    for (int i = 0; i < 8; ++i)
        bytes[42 + static_cast<std::size_t>(i)] = static_cast<char>(body_bytes >> (56 - 8 * i));
    return bytes;
}

void garbage_from_a_client_changes_nothing(void **)
{
    const unsigned seed = 20261127;
    std::printf("# seed %u\n", seed);
    std::mt19937 random(seed);
    const auto server = open();
    Client good(*server);
    RawClient noise(*server), giant(*server), cut(*server);
    wait_until([&] { return server->clients() == 4; });
    giant.send(header_with("IMAGE", UINT64_MAX));
    cut.send(header_with("GET_STATUS", 0).substr(0, 30));
    for (std::uint32_t tick = 1; tick <= 50; ++tick) {
        std::string bytes(20'000, '\0');
        for (char &byte : bytes) byte = static_cast<char>(random());
        noise.send(bytes);
        giant.send(header_with("STT_TDATA", tick) + bytes.substr(0, 100));
        server->publish(moment(tick));
        assert_receives(good, tick);
    }
    assert_int_equal(server->clients(), 4);
}

void a_client_that_disappears_is_forgotten(void **)
{
    const auto server = open();
    Client good(*server);
    {
        RawClient gone(*server, 4096);
        wait_until([&] { return server->clients() == 2; });
        for (std::uint32_t tick = 1; tick <= 20; ++tick) {
            server->publish({{"Fluoroscopy", {tick, picture_of(512, 1)}}});
            good.wait_for<igtl::ImageMessage>("IMAGE");
        }
        gone.reset();
    }
    wait_until([&] { return server->clients() == 1; });
    server->publish(moment(30));
    assert_receives(good, 30);
}

void a_client_that_takes_nothing_for_too_long_is_closed(void **)
{
    IgtlLimits limits;
    limits.stall = milliseconds(20);
    const auto server = open(limits);
    RawClient dead(*server, 4096);
    wait_until([&] { return server->clients() == 1; });
    for (std::uint32_t tick = 1; tick <= 20; ++tick)
        server->publish({{"Fluoroscopy", {tick, picture_of(2048, 1)}}});
    wait_until([&] { return server->clients() == 0; });
}

void more_clients_than_allowed_are_closed_at_once(void **)
{
    IgtlLimits limits;
    limits.clients = 2;
    const auto server = open(limits);
    Client first(*server), second(*server);
    wait_until([&] { return server->clients() == 2; });
    RawClient third(*server);
    assert_true(third.is_closed_by_server());
    server->publish(moment(3));
    assert_receives(first, 3);
    assert_receives(second, 3);
}

void the_end_of_the_server_sends_what_waits_and_closes(void **)
{
    auto server = open();
    Client client(*server);
    wait_until([&] { return server->clients() == 1; });
    server->publish({{"Cournand", {9, IgtlStatus{false, "the session has ended"}}}});
    server.reset();
    const auto status = client.wait_for<igtl::StatusMessage>("STATUS");
    assert_int_equal(status->GetCode(), igtl::StatusMessage::STATUS_SHUT_DOWN);
    assert_false(client.next());
}

void a_port_in_use_is_refused_with_its_place_and_a_remedy(void **)
{
    const auto server = open();
    const IgtlAddress same = server->address();
    try {
        open_igtl(same);
        fail_msg("the port %u was opened twice", unsigned{same.port});
    } catch (const std::runtime_error &error) {
        assert_non_null(std::strstr(error.what(), ("cannot wait for clients at " + same.text()).c_str()));
        assert_non_null(std::strstr(error.what(), "Address already in use"));
        assert_non_null(std::strstr(error.what(), "Remedy: end the program that uses this port"));
    }
}

void a_host_that_is_not_this_machine_is_refused(void **)
{
    for (const char *host : {"192.0.2.1", "no..host"}) {
        try {
            open_igtl({host, 0});
            fail_msg("%s was opened", host);
        } catch (const std::runtime_error &error) {
            assert_non_null(std::strstr(error.what(), host));
            assert_non_null(std::strstr(error.what(), "Remedy: name an address of this machine"));
        }
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_client_of_libopenigtlink_receives_status_picture_and_pose),
        cmocka_unit_test(a_client_that_comes_later_receives_the_present_state),
        cmocka_unit_test(two_clients_receive_the_same),
        cmocka_unit_test(a_client_that_reads_nothing_stops_neither_the_session_nor_another_client),
        cmocka_unit_test(a_slow_client_receives_the_newest_picture_in_the_end),
        cmocka_unit_test(garbage_from_a_client_changes_nothing),
        cmocka_unit_test(a_client_that_disappears_is_forgotten),
        cmocka_unit_test(a_client_that_takes_nothing_for_too_long_is_closed),
        cmocka_unit_test(more_clients_than_allowed_are_closed_at_once),
        cmocka_unit_test(the_end_of_the_server_sends_what_waits_and_closes),
        cmocka_unit_test(a_port_in_use_is_refused_with_its_place_and_a_remedy),
        cmocka_unit_test(a_host_that_is_not_this_machine_is_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
