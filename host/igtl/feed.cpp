#include "host/igtl/feed.hpp"
#include "host/base/terminal.hpp"
#include "host/igtl/geometry.hpp"
#include <cstdio>

namespace crn
{

namespace
{

bool is_on_line(const Patient &patient, std::size_t position)
{
    return position >= patient.line().size() || patient.line()[position] != 0;
}

const char *beam_text(const RoomState &room, RunKind kind)
{
    if (!room.is_beam_on) return "off";
    return kind == RunKind::fluoro ? "fluoroscopy" : kind == RunKind::cine ? "cine" : "DSA";
}

// Describes the session in one line, such as "X-ray: off; Tool1Tip: J wire".
std::string status_text(const Patient &patient, std::size_t tips)
{
    const RoomState room = patient.room().state();
    std::string text = std::string("X-ray: ") + beam_text(room, patient.room().pulse().kind);
    for (std::size_t k = 0; k < tips; ++k)
        if (is_on_line(patient, k))
            text += "; " + igtl_tip_name(k) + ": " +
                    (k < patient.tools().size() ? patient.tools()[k].name : std::string());
    return text;
}

} // namespace

void IgtlFeed::send(const SessionFrame &frame, const Patient &patient, const IgtlPicture *picture)
{
    const WireFrame &wire = frame.wire;
    tick_ = wire.tick;
    IgtlFrame moment;
    moment[igtl_carm_name] = {tick_, carm_pose(patient.room().state().carm)};
    for (std::size_t k = 0; k < wire.tip_arc_m.size(); ++k)
        if (const auto pose = tip_pose(wire, wire.tip_arc_m[k]); pose && is_on_line(patient, k))
            moment[igtl_tip_name(k)] = {tick_, *pose};
    if (picture) moment[igtl_picture_name] = {tick_, *picture};
    const std::string text = status_text(patient, wire.tip_arc_m.size());
    if (text != told_.text || tick_ >= told_tick_ + status_every_ticks || tick_ < told_tick_) {
        told_ = {true, text};
        told_tick_ = tick_;
        moment[igtl_status_name] = {tick_, told_};
    }
    server_.publish(std::move(moment));
}

void IgtlFeed::end()
{
    server_.publish({{igtl_status_name, {tick_, IgtlStatus{false, "the session has ended"}}}});
}

void IgtlSink::frame(const SessionFrame &frame)
{
    Image image = pictures_.plain_image();
    if (image.bytes.empty() || (shown_ && *shown_ == image.bytes))
        return feed_.send(frame, patient_, nullptr);
    IgtlPicture picture = picture_place(pictures_.screen().status().picture_carm, image.width);
    shown_ = std::make_shared<const std::vector<std::uint8_t>>(std::move(image.bytes));
    picture.grey = shown_;
    feed_.send(frame, patient_, &picture);
}

std::shared_ptr<IgtlServer> open_told_igtl(const std::string &address)
{
    if (address.empty()) return nullptr;
    std::shared_ptr<IgtlServer> server = open_igtl(parse_igtl_address(address));
    const IgtlAddress at = server->address();
    say(stdout, "OpenIGTLink: waits for clients at %s, %s\n", at.text().c_str(),
        at.is_local() ? "from this machine only" : "from every machine that reaches it, without a password");
    std::fflush(stdout);
    return server;
}

IgtlOutput::IgtlOutput(const std::string &address) : server_(open_told_igtl(address)) {}

FrameSink *IgtlOutput::with(SessionPictures *pictures, const Patient *patient)
{
    if (!server_ || !pictures || !patient) return pictures;
    sink_.emplace(*server_, *patient, *pictures);
    both_.add(pictures);
    both_.add(&*sink_);
    return &both_;
}

} // namespace crn
