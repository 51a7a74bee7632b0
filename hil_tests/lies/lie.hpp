// Lists the lies (false messages) that a simulated device can send. One line of text identifies a lie
// completely, for example "ticks.lane0 at=3 value=0".
//
//   stream.*   from the n-th frame on the device only does this, for ever: zeros, garbage, silence, drips
//   frame.*    the n-th frame is damaged, lost, repeated, or answers something else
//   message.*  its payload is another one, with a good CRC
//   others     one field of the n-th message of that type is changed; where a command gets no such message, a
//              forged one comes unsolicited
#pragma once
#include <string>
#include <vector>

namespace hil
{

struct Lie {
    std::string name;
    unsigned at = 1;
    unsigned value = 0;
    bool is(const char *whole) const { return name == whole; }
    bool is_group(const char *prefix) const { return name.rfind(prefix, 0) == 0; }
    std::string group() const { return name.substr(0, name.find('.')); }
    std::string word() const { return name.substr(name.find('.') + 1); }
};

std::string line_of(const Lie &lie);
// Makes a Lie from a line of text that names it. Throws std::invalid_argument if a word of the line is
// unknown; the message contains that word.
Lie lie_of_line(const std::string &line);

std::vector<Lie> stream_lies(); // of the wire
std::vector<Lie> hid_lies();    // of the HID interface.
// Returns `count` lies, spread evenly.
std::vector<Lie> spread_lies(const std::vector<Lie> &lies, std::size_t count);

} // namespace hil
