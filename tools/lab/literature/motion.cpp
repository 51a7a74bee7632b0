// Measures how the arteries of the shipped heart move with heartbeat and breath, as angiography and CT do.
#include "tools/anatomy/heart_sequence.hpp"
#include "tools/anatomy/soft/breath.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include "tools/lab/literature/experiments.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crn::literature
{

namespace
{

using anatomy::Vec3;
constexpr double degree = M_PI / 180;
constexpr int moments = 240; // of the beat
constexpr double moment_ms = anatomy::BEAT_MS / moments;

struct Heart {
    anatomy::VesselTree tree = anatomy::shipped_vessels("heart");
    anatomy::HeartBeat beat{tree.vessels.front()};
};

// Points of an artery, every 2 mm from its beginning to a share of its length, at all moments of a beat.
class Artery
{
  public:
    Artery(const Heart &heart, const std::string &name, double share)
    {
        const auto found = std::find_if(heart.tree.vessels.begin(), heart.tree.vessels.end(),
                                        [&](const anatomy::Vessel &vessel) { return vessel.name == name; });
        if (found == heart.tree.vessels.end()) throw std::runtime_error("the heart has no artery " + name);
        const anatomy::Curve curve = anatomy::vessel_curve(*found, 2.0);
        const auto count = std::max<std::size_t>(2, std::size_t(share * double(curve.size())));
        for (std::size_t i = 0; i < std::min(count, curve.size()); i++) {
            rest_.push_back(curve[i].position_mm);
            frames_.push_back(heart.beat.frames(curve[i].position_mm));
            inhaled_.push_back(heart.beat.inhaled(curve[i].position_mm));
        }
    }

    std::size_t size() const { return rest_.size(); }
    const std::vector<Vec3> &rest() const { return rest_; }
    const std::vector<Vec3> &inhaled() const { return inhaled_; }

    // Catmull-Rom between the 24 frames.
    Vec3 at(std::size_t point, double phase) const
    {
        const double frame = (phase - std::floor(phase)) * anatomy::BEAT_FRAMES,
                     t = frame - std::floor(frame);
        const auto p = [&](int k) {
            const int index = (int(frame) + k + anatomy::BEAT_FRAMES) % anatomy::BEAT_FRAMES;
            return frames_[point][std::size_t(index)];
        };
        return p(0) + 0.5 * t *
                          ((p(1) - p(-1)) + t * ((2 * p(-1) - 5 * p(0) + 4 * p(1) - p(2)) +
                                                 t * (3 * (p(0) - p(1)) + p(2) - p(-1))));
    }

  private:
    std::vector<Vec3> rest_, inhaled_;
    std::vector<std::vector<Vec3>> frames_;
};

double mean_displacement_mm(const std::vector<Artery> &arteries, double from, double to)
{
    double sum = 0, count = 0;
    for (const Artery &artery : arteries) {
        for (std::size_t i = 0; i < artery.size(); i++) {
            sum += (artery.at(i, to) - artery.at(i, from)).norm();
            count++;
        }
    }
    return sum / count;
}

// The longest time in which the arteries stay within 1 mm of where they were at its beginning, if it begins
// in a part of the beat.
double rest_ms(const std::vector<Artery> &arteries, double begin, double end)
{
    int longest = 0;
    for (int first = int(begin * moments); first <= int(end * moments); first++) {
        int count = 0;
        while (count < moments / 2 && mean_displacement_mm(arteries, double(first) / moments,
                                                           double(first + count + 1) / moments) < 1)
            count++;
        longest = std::max(longest, count);
    }
    return longest * moment_ms;
}

// The share of the breath, which the core gives the depth sin^4(pi phase), in which a displacement of
// `largest_mm` stays below half a millimetre.
double breath_rest_percent(double largest_mm)
{
    constexpr int steps = 10000;
    int still = 0;
    for (int k = 0; k < steps; k++)
        still += largest_mm * std::pow(std::sin(M_PI * (k + 0.5) / steps), 4) < 0.5;
    return 100.0 * still / steps;
}

double mean_breath_mm(const std::vector<Artery> &arteries)
{
    double sum = 0, count = 0;
    for (const Artery &artery : arteries) {
        for (std::size_t i = 0; i < artery.size(); i++) {
            sum += (artery.inhaled()[i] - artery.rest()[i]).norm();
            count++;
        }
    }
    return sum / count;
}

Figures rest_periods()
{
    const Heart heart;
    // The source measures the proximal and middle right artery, and the proximal 5 cm of the left tree.
    const std::vector<Artery> right{Artery(heart, "RCA", 0.6)},
        left{Artery(heart, "LM", 1), Artery(heart, "LAD", 0.5), Artery(heart, "LCX", 0.8)};
    Figures figures;
    figures.values = {{"rca_systole", rest_ms(right, 0.30, 0.55)},
                      {"rca_diastole", rest_ms(right, 0.60, 0.95)},
                      {"left_systole", rest_ms(left, 0.30, 0.55)},
                      {"left_diastole", rest_ms(left, 0.60, 0.95)},
                      {"rca_breath", breath_rest_percent(mean_breath_mm(right))},
                      {"left_breath", breath_rest_percent(mean_breath_mm(left))}};
    validate::Plot plot{
        "Displacement since the end of diastole", "time since the QRS (ms)", "mean displacement (mm)", {}};
    for (auto [name, arteries] : {std::pair{"right", &right}, {"left", &left}}) {
        validate::Series series{name, {}, {}};
        for (int k = 0; k <= moments; k += 4) {
            series.x.push_back(k * moment_ms);
            series.y.push_back(mean_displacement_mm(*arteries, 0, double(k) / moments));
        }
        plot.series.push_back(series);
    }
    figures.curves.push_back(plot);
    return figures;
}

// Mean speed over the beat in the plane of a CT slice, x and z of the patient.
double slice_speed_mm_s(const Artery &artery)
{
    double way = 0;
    for (std::size_t i = 0; i < artery.size(); i++) {
        for (int k = 0; k < moments; k++) {
            const Vec3 step = artery.at(i, double(k + 1) / moments) - artery.at(i, double(k) / moments);
            way += std::hypot(step[0], step[2]);
        }
    }
    return way / double(artery.size()) / (anatomy::BEAT_MS * 1e-3);
}

Figures slice_speeds()
{
    const Heart heart;
    const double rca = slice_speed_mm_s({heart, "RCA", 1}), lcx = slice_speed_mm_s({heart, "LCX", 1}),
                 lm = slice_speed_mm_s({heart, "LM", 1}), lad = slice_speed_mm_s({heart, "LAD", 1});
    return {{{"rca", rca},
             {"lcx", lcx},
             {"lm", lm},
             {"lad", lad},
             {"rca_over_lcx", rca / lcx},
             {"lcx_over_lm", lcx / lm},
             {"lm_over_lad", lm / lad}},
            {}};
}

// Fits a rotation and a shift to the motion of all points by a breath (Kabsch), as a rigid-body model does.
Figures breath_of_the_heart()
{
    const Heart heart;
    std::vector<Vec3> from, to;
    for (const char *name : {"LM", "LAD", "LCX", "RCA"}) {
        const Artery artery(heart, name, 1);
        from.insert(from.end(), artery.rest().begin(), artery.rest().end());
        to.insert(to.end(), artery.inhaled().begin(), artery.inhaled().end());
    }
    const auto middle = [](const std::vector<Vec3> &points) {
        Vec3 sum = Vec3::Zero();
        for (const Vec3 &point : points) sum += point;
        return Vec3(sum / double(points.size()));
    };
    const Vec3 before = middle(from), after = middle(to);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < from.size(); i++)
        covariance += (to[i] - after) * (from[i] - before).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
    // x is the patient's left, y the head, z the front: a cranio-dorsal rotation is one about x.
    return {{{"caudal", before[1] - after[1]},
             {"anterior", after[2] - before[2]},
             {"cranio_dorsal", std::fabs(std::atan2(turn(2, 1), turn(2, 2))) / degree},
             {"caudo_dextral", std::atan2(turn(1, 0), turn(0, 0)) / degree}},
            {}};
}

// The tops of the domes of the shipped patient, whose heart does not beat.
const Vec3 right_dome_mm{-62, 77, 8}, left_dome_mm{62, 65, 8};

double descent_mm(const Vec3 &top)
{
    const anatomy::VesselTree arteries = anatomy::shipped_vessels("aorta");
    return top.y() - anatomy::Breath(arteries, {}).inhaled(top).y();
}

Figures domes()
{
    return {{{"right", descent_mm(right_dome_mm)}, {"left", descent_mm(left_dome_mm)}}, {}};
}

Figures heart_over_diaphragm()
{
    const Heart heart;
    const Artery left_main(heart, "LM", 1);
    double sum = 0;
    for (std::size_t i = 0; i < left_main.size(); i++)
        sum += left_main.rest()[i].y() - left_main.inhaled()[i].y();
    return {{{"ratio", sum / double(left_main.size()) / descent_mm(right_dome_mm)}}, {}};
}

} // namespace

std::vector<Experiment> motion_experiments()
{
    return {{"coronary_rest", rest_periods},
            {"coronary_speed", slice_speeds},
            {"heart_breath", breath_of_the_heart},
            {"diaphragm_breath", domes},
            {"heart_over_diaphragm", heart_over_diaphragm}};
}

} // namespace crn::literature
