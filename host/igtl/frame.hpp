// Holds the data that the OpenIGTLink server sends for one moment of a session: poses, picture and status, in
// the axes and units of OpenIGTLink (RAS, mm; docs/slicer.md). It is plain data.
#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace crn
{

// A frame of axes in the patient; it is sent as TRANSFORM.
using IgtlPose = Eigen::Isometry3d;

// A grey picture with its position in the patient; it is sent as an IMAGE message. The columns of the pose's
// rotation are the directions in which column numbers, row numbers and slice numbers rise; the origin of the
// pose is the picture's centre.
struct IgtlPicture {
    int size = 0;                                          // pixels along each edge
    std::shared_ptr<const std::vector<std::uint8_t>> grey; // size * size pixels, row 0 is the top row
    double pixel_mm = 1.0;
    IgtlPose pose = IgtlPose::Identity();
};

// The state of the session; it is sent as STATUS.
struct IgtlStatus {
    bool is_running = true; // false: the session has ended
    std::string text;
};

struct IgtlItem {
    std::uint32_t tick = 0; // of the session
    std::variant<IgtlPose, IgtlPicture, IgtlStatus> content;
};

// The data of one moment, by the device names of the OpenIGTLink messages.
using IgtlFrame = std::map<std::string, IgtlItem>;

inline constexpr char igtl_carm_name[] = "CArm";
inline constexpr char igtl_picture_name[] = "Fluoroscopy";
inline constexpr char igtl_status_name[] = "Cournand";
// Returns the message name of the tip of the tool at a position (0 is the innermost), for example "Tool1Tip".
inline std::string igtl_tip_name(std::size_t position)
{
    return "Tool" + std::to_string(position + 1) + "Tip";
}

} // namespace crn
