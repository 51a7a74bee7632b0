/* Grows small arteries from larger ones into tissue, by constrained constructive optimisation (Schreiner and
 * Buxbaum 1993): one end after the other joins the tree where this adds the least volume of blood. The radius
 * of an artery follows from the number of its ends by Murray's law with the given exponent. */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <functional>

namespace anatomy
{

/* A place in tissue. In a layer of tissue, such as the outer wall of the heart, `depth_mm` is measured across
 * the layer. Arteries of one layer do not join those of another. */
struct TissuePlace {
    Vec3 at;
    double depth_mm = 0.0;
    int layer = 0;
};

/* Puts a place that lies near its layer back to its depth in the layer. */
using OntoTissue = std::function<TissuePlace(const TissuePlace &)>;

struct GrowthRules {
    double exponent = 7.0 / 3.0; // of Murray's law
    double end_radius_mm = 0.15;
    double step_mm = 3.0;      // between the points of a grown artery
    double reach_mm = 35.0;    // farther ends are left out
    double widest_share = 0.8; // of the radius of the vessel from which a small artery leaves
};

/* A grown artery, from where it leaves another one to its end; at each fork, it follows the wider branch. */
struct Twig {
    std::string stem;  // the vessel from which it leaves; "": it leaves an earlier twig
    size_t parent = 0; // that twig
    std::vector<CurvePoint> points;
};

class Growth
{
  public:
    Growth(OntoTissue onto, const GrowthRules &rules) : onto_(std::move(onto)), rules_(rules) {}

    /* Adds a stretch of a large vessel, whose course and radii do not change. Over the last closed_mm, only
     * trunks leave it: the flow through its end is then as large as the end is wide. */
    void add_stem(const std::string &name, const std::vector<TissuePlace> &places,
                  const std::vector<double> &radii_mm, double closed_mm = 0.0);
    /* Adds an artery of a given course. Its first place lies on the stem that was added last. */
    void add_trunk(const std::vector<TissuePlace> &places);
    /* Grows an artery to the place. Returns false if no artery of its layer is near enough. */
    bool grow_to(const TissuePlace &end);

    std::vector<Twig> twigs() const;
    /* The number of ends behind each twig, and the stem that feeds it. */
    struct Segment {
        TissuePlace from, to;
        int parent = -1; // the segment before it; -1: of a stem
        int stem = 0;    // index of the stem's name
        bool is_stem = false, is_closed = false;
        double stem_radius_mm = 0.0;
        int ends = 0; // of a grown artery: how many ends it feeds
        std::vector<int> children;
    };
    const std::vector<Segment> &segments() const { return segments_; }
    const std::string &stem_name(int stem) const { return stems_[static_cast<size_t>(stem)]; }
    double radius_mm(int ends) const;

  private:
    struct Joint {
        int segment = -1;
        TissuePlace at;
        double cost = 1e300;
    };
    int add_segment(const Segment &segment);
    std::vector<int> nearest(const TissuePlace &end) const;
    void try_segment(int index, const TissuePlace &end, Joint &best) const;
    double cost_upstream(int index) const;
    void count_ends(int index);
    struct Start { // of a twig
        std::string stem;
        size_t parent = 0;
        Vec3 at = Vec3::Zero();
    };
    void trace(int first, const Start &start, std::vector<Twig> &twigs) const;
    void add_points(const Segment &segment, double to_radius_mm, std::vector<CurvePoint> &points) const;

    OntoTissue onto_;
    GrowthRules rules_;
    std::vector<std::string> stems_;
    std::vector<Segment> segments_;
};

} // namespace anatomy
