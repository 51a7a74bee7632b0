// Changes the meshes around lesions that a balloon has opened: the surface of the blood moves back to the
// healthy wall, and pushes calcium outwards.
//
//   OpenedBodies opened(bodies, opening, motion);
//   for (const auto &body : opened.at(moment, wire.lesions_open, moving.at(moment))) ...
//
// Only vertices near a lesion can move. While all lesions are as narrow as in the scene file, no vertex
// moves.
#pragma once
#include "host/model/lesion_opening.hpp"
#include "host/model/motion.hpp"

namespace crn
{

class LesionWall;

class OpenedBodies
{
  public:
    // Finds the vertices near each lesion in two bodies: the blood of the lesion's vessel, and the calcium
    // that `bake` made for the lesion (LESION_calcium). `motion` may be null if no body moves.
    OpenedBodies(const Bodies &bodies, const LesionOpening &opening, const Motion *motion);

    bool is_empty() const { return opened_.empty(); }
    std::size_t vertex_count() const; // number of vertices that move with lesions
    std::vector<int> bodies() const;  // bodies that have such vertices

    // Returns the bodies (closed meshes) whose present shape differs from that in the scene file: those in
    // `moved`, which the heart moves, and those that open lesions change. The list that this function returns
    // is valid until the next call.
    const std::vector<MovingBodies::Moved> &at(const MotionMoment &moment,
                                               std::span<const double> lesions_open,
                                               std::span<const MovingBodies::Moved> moved = {});

  private:
    struct Vertex {
        std::uint32_t index = 0;
        LesionOpening::Place place;
        Eigen::Vector3d healthy_m = Eigen::Vector3d::Zero(); // in the reference pose
    };
    struct Opened {
        int body = 0;
        std::vector<std::size_t> lesions; // lesions that reach it
        std::vector<Vertex> vertices;
        std::optional<MovingPoints> healthy; // for a body that moves
        std::vector<Eigen::Vector3i> narrow_um, vertices_um;
    };
    void find_wall(const Body &body, std::size_t lesion, const LesionWall &wall, Opened &opened) const;
    void find_calcium(const Body &body, std::size_t lesion, const LesionWall &wall, Opened &opened) const;
    static void place(Opened &opened, std::span<const Eigen::Vector3i> narrow_um,
                      const MotionWeights &weights, std::span<const double> lesions_open);

    LesionOpening opening_;
    std::vector<Opened> opened_;
    std::vector<MovingBodies::Moved> at_;
};

} // namespace crn
