// Converts those statements of a session script that concern the X-ray room (docs/session.md) to commands.
#pragma once
#include "host/room/command.hpp"
#include "host/script/line.hpp"
#include <vector>

namespace crn
{

const std::vector<std::string> &room_verbs();

// Remembers the settings of the previous lines, because a statement may leave some of these settings
// unchanged.
class RoomParser
{
  public:
    // Parses the words of a line after `verb`. Throws FileError; the message gives the line's position in the
    // file.
    std::vector<RoomCommand> parse(LineParser &line, const std::string &verb);

  private:
    void c_arm(LineParser &line);
    void preset(LineParser &line);
    void table(LineParser &line);
    void pedal(LineParser &line, const std::string &verb);
    void blades(LineParser &line);
    void mask(LineParser &line);
    void roadmap(LineParser &line);
    void review(LineParser &line);
    void shift(LineParser &line);
    void inject(LineParser &line);
    void add(RoomAction action, std::int32_t a = 0, std::int32_t b = 0, std::int32_t c = 0);

    std::vector<RoomCommand> commands_;
    std::int32_t primary_mdeg_ = 0, secondary_mdeg_ = 0;
    std::int32_t table_um_[3] = {0, 0, 0};
    std::int32_t sid_um_ = 1'050'000, sod_um_ = 750'000;
    std::int32_t width_permille_ = 970, height_permille_ = 970;
};

} // namespace crn
