// Publishes a session by OpenIGTLink: the poses of tips and C-arm, each new picture, and the status. It only
// reads the session.
#pragma once
#include "host/igtl/server.hpp"
#include "host/patient/patient.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/session/frame_sink.hpp"
#include <memory>
#include <optional>
#include <string>

namespace crn
{

class IgtlFeed
{
  public:
    // While a client watches a session, it receives a status at least this often, in ticks.
    static constexpr std::uint32_t status_every_ticks = 1000;

    explicit IgtlFeed(IgtlServer &server) : server_(server) {}
    // Publishes one moment. `picture` is null if the picture has not changed.
    void send(const SessionFrame &frame, const Patient &patient, const IgtlPicture *picture);
    void end(); // publishes that the session has ended

  private:
    IgtlServer &server_;
    IgtlStatus told_;
    std::uint32_t tick_ = 0, told_tick_ = 0;
};

// Publishes the session's state after each picture, for the same frames for which pictures are made.
class IgtlSink final : public FrameSink
{
  public:
    IgtlSink(IgtlServer &server, const Patient &patient, const SessionPictures &pictures)
        : feed_(server), patient_(patient), pictures_(pictures)
    {
    }
    std::uint32_t next_tick() const override { return UINT32_MAX; } // the pictures choose the frames
    void frame(const SessionFrame &frame) override;
    void finish() override { feed_.end(); }

  private:
    IgtlFeed feed_;
    const Patient &patient_;
    const SessionPictures &pictures_;
    std::shared_ptr<const std::vector<std::uint8_t>> shown_; // the last published picture
};

// Holds the server that the option --igtl requests, if the user gave this option.
class IgtlOutput
{
  public:
    // If `address` is empty, there is no server. If `address` is not empty, the constructor starts the server
    // and prints its address. Throws the exceptions of parse_igtl_address() and open_igtl().
    explicit IgtlOutput(const std::string &address);
    IgtlServer *server() const { return server_.get(); }
    // Returns the observer that makes `pictures` of a session and, if there is a server, also publishes them.
    // `pictures` and `patient` must live longer than the session.
    FrameSink *with(SessionPictures *pictures, const Patient *patient);

  private:
    std::shared_ptr<IgtlServer> server_;
    std::optional<IgtlSink> sink_;
    FrameSinks both_;
};

// Starts the server of the option --igtl, and prints the server's address. Returns null if `address` is
// empty.
std::shared_ptr<IgtlServer> open_told_igtl(const std::string &address);

} // namespace crn
