// Reads the meshes of vessels as a person has them, one file or many, and finds unit, axes and arteries.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/patient/choices.hpp"

#include <set>

namespace crn::patient
{

// One named part, in the scene's axes and millimetres. Its vertices are merged; it may be open or cross
// itself.
struct Part {
    std::string name;
    bake::Mesh mesh;
};

struct PartsWish {
    std::vector<std::filesystem::path> files;
    std::vector<std::string> parts; // names, may end in '*'; empty: the arteries, or all
    std::string unit;               // empty: found
    std::string axes;               // "+x,+z,-y": the file's axes that are left, head and front; empty: found
};

// Where the coordinates of a file lie in the scene.
struct Frame {
    std::string unit, axes;
    bake::Placement placement;
};

// Reads the parts of all files. Throws Fault if a file is unreadable, has no triangle or no part of a name.
std::vector<Part> read_parts(const PartsWish &wish, Choices &choices, Frame &frame);

// The turn of axes that a text such as "+x,+z,-y" states. Throws UsageError.
Eigen::Matrix3d axes_of(const std::string &text);

// Gives branches names as a scene can store them: at most 31 letters, and each name once.
class BranchNames
{
  public:
    std::string add(std::string wanted); // the name, cut or with a number where that is needed

  private:
    std::set<std::string> used_;
};

// Names without what all begin with ("VH_M_"), in small letters, as BranchNames gives them. The choices say
// which names are cut.
std::vector<std::string> short_names(const std::vector<std::string> &names, Choices *choices = nullptr);

// Whether a part's name is that of an artery of the body's circulation; veins and pulmonary arteries are not.
bool is_artery_name(const std::string &name);

} // namespace crn::patient
