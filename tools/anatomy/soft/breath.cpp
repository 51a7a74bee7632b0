#include "tools/anatomy/soft/breath.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

constexpr double FREE_MM = 60.0; // so far from bones, tissue moves freely
/* The lattice encloses chest and belly; its outermost nodes stay. */
constexpr double SPACING_MM = 8.0;
constexpr int NODES[3] = {37, 78, 29};
const Vec3 FIRST_MM(-144.0, -312.0, -116.0);

/* Returns the share of the dome's motion at a height in the free middle of chest or belly. */
double share_at_height(double y)
{
    constexpr double PELVIS_MM = -290.0, LIVER_MM = -20.0, DOME_TOP_MM = 70.0, APEX_MM = 285.0;
    if (y > DOME_TOP_MM) return std::clamp((APEX_MM - y) / (APEX_MM - DOME_TOP_MM), 0.0, 1.0);
    return smooth_step(PELVIS_MM, LIVER_MM, y);
}

} // namespace

bool breathes(const std::string &body)
{
    for (const char *name :
         {"lung_right", "lung_left", "lung_right_vessels", "lung_left_vessels", "heart", "left_ventricle",
          "right_ventricle", "left_atrium", "right_atrium", "pacing_lead_atrium", "pacing_lead_ventricle",
          "belly_fat", "liver", "spleen", "bowel", "bowel_gas", "faeces_gas"})
        if (body == name) return true;
    return false;
}

namespace
{

/* Computes the displacement at single points. */
class Field
{
  public:
    Field(const VesselTree &tree, const Person &person);
    Vec3 way(const Vec3 &point) const;
    Field near(const Box &box) const; // faster, for points in the box

  private:
    Solid bones_, tubes_, heart_, nests_;
};

Field::Field(const VesselTree &tree, const Person &person)
    : tubes_(vessels_solid(body_vessels(tree), 0.0, tree.fillet_mm)), heart_(heart_outline()),
      nests_(kidney_nests())
{
    const SkeletonShape shape = skeleton_shape(person);
    bones_ = spine_bones(shape);
    bones_.add(rib_bones(shape));
    bones_.add(costal_cartilages(shape));
    bones_.add(pelvis_bones(shape));
    tubes_.add(airway());
}

Field Field::near(const Box &box) const
{
    Field field = *this;
    field.bones_ = bones_.near(box, FREE_MM);
    field.tubes_ = tubes_.near(box, FREE_MM);
    return field;
}

Vec3 Field::way(const Vec3 &point) const
{
    constexpr double HEART_REACH_MM = 28.0, HEART_OWN_MM = 30.0, HELD_MM = 2.0, NEST_MM = 12.0, SOONER = 1.5,
                     BLEND_MM = 8.0, BEHIND_MM = -70.0, BEFORE_MM = 10.0;
    const double to_heart = heart_.distance(point);
    // The heart slides along the sternum; other tissue, and the back of the heart, stick to what stays.
    const double slides =
        (1.0 - smooth_step(0.0, HEART_OWN_MM, to_heart)) * smooth_step(BEHIND_MM, BEFORE_MM, point.z());
    // Tissue moves freely nearer to arteries and kidneys than to bones.
    double away = smooth_min(SOONER * tubes_.distance(point), bones_.distance(point), BLEND_MM);
    away = smooth_min(away, SOONER * (nests_.distance(point) + NEST_MM), BLEND_MM);
    const double free = std::lerp(smooth_step(HELD_MM, FREE_MM, away), 1.0, slides);
    const double of_heart = 1.0 - smooth_step(0.0, HEART_REACH_MM, to_heart);
    const double down = std::lerp(DOME_MM * share_at_height(point.y()), HEART_DOWN_MM, of_heart);
    return free * Vec3(0.0, -down, HEART_FORWARD_MM * of_heart);
}

Vec3 node_mm(int x, int y, int z)
{
    return FIRST_MM + SPACING_MM * Vec3(x, y, z);
}

size_t index_of(int x, int y, int z)
{
    return (static_cast<size_t>(z) * NODES[1] + static_cast<size_t>(y)) * NODES[0] + static_cast<size_t>(x);
}

} // namespace

Breath::Breath(const VesselTree &tree, const Person &person)
    : ways_mm_(index_of(0, 0, NODES[2]), Vec3::Zero())
{
    constexpr int BLOCK = 4; // nodes of a block share what is near them
    const Field whole(tree, person);
    for (int z0 = 1; z0 < NODES[2] - 1; z0 += BLOCK)
        for (int y0 = 1; y0 < NODES[1] - 1; y0 += BLOCK)
            for (int x0 = 1; x0 < NODES[0] - 1; x0 += BLOCK) {
                const int x1 = std::min(x0 + BLOCK, NODES[0] - 1), y1 = std::min(y0 + BLOCK, NODES[1] - 1),
                          z1 = std::min(z0 + BLOCK, NODES[2] - 1);
                Box box;
                box.include(node_mm(x0, y0, z0), 0.0);
                box.include(node_mm(x1, y1, z1), 0.0);
                const Field field = whole.near(box);
                for (int z = z0; z < z1; z++)
                    for (int y = y0; y < y1; y++)
                        for (int x = x0; x < x1; x++)
                            ways_mm_[index_of(x, y, z)] = field.way(node_mm(x, y, z));
            }
    for (const size_t step : {index_of(1, 0, 0), index_of(0, 1, 0), index_of(0, 0, 1)}) smooth(step);
}

/* Distances to bones jump by some millimetres where the nearest piece of a bone changes, so each node takes
 * half of its displacement from its two neighbours along one axis. */
void Breath::smooth(size_t step)
{
    const std::vector<Vec3> before = ways_mm_;
    for (int z = 1; z < NODES[2] - 1; z++)
        for (int y = 1; y < NODES[1] - 1; y++)
            for (int x = 1; x < NODES[0] - 1; x++) {
                const size_t i = index_of(x, y, z);
                ways_mm_[i] = 0.5 * before[i] + 0.25 * (before[i - step] + before[i + step]);
            }
}

const Vec3 &Breath::way(int x, int y, int z) const
{
    return ways_mm_[index_of(x, y, z)];
}

Vec3 Breath::inhaled(const Vec3 &point) const
{
    const Vec3 place = (point - FIRST_MM) / SPACING_MM;
    int cell[3];
    double share[3];
    for (int axis = 0; axis < 3; axis++) {
        if (!(place[axis] > 0.0 && place[axis] < NODES[axis] - 1)) return point;
        cell[axis] = static_cast<int>(place[axis]);
        share[axis] = place[axis] - cell[axis];
    }
    Vec3 sum = Vec3::Zero();
    for (int corner = 0; corner < 8; corner++) {
        const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const double weight = (x ? share[0] : 1.0 - share[0]) * (y ? share[1] : 1.0 - share[1]) *
                              (z ? share[2] : 1.0 - share[2]);
        sum += weight * way(cell[0] + x, cell[1] + y, cell[2] + z);
    }
    return point + sum;
}

std::vector<Vec3> Breath::inhaled(const std::vector<Vec3> &points) const
{
    std::vector<Vec3> moved;
    for (const Vec3 &point : points) moved.push_back(inhaled(point));
    return moved;
}

double Breath::least_volume_factor() const
{
    double least = 1.0;
    for (int z = 0; z < NODES[2]; z++)
        for (int y = 0; y < NODES[1]; y++)
            for (int x = 0; x < NODES[0]; x++) {
                const int here[3] = {x, y, z};
                Vec3 edges[3];
                for (int axis = 0; axis < 3; axis++) { // towards the neighbour that exists
                    const int to = here[axis] + 1 < NODES[axis] ? 1 : -1;
                    const Vec3 along = to * Vec3::Unit(axis);
                    edges[axis] =
                        along + (way(x + to * (axis == 0), y + to * (axis == 1), z + to * (axis == 2)) -
                                 way(x, y, z)) /
                                    SPACING_MM;
                    edges[axis] *= to;
                }
                least = std::min(least, edges[0].cross(edges[1]).dot(edges[2]));
            }
    return least;
}

} // namespace anatomy
