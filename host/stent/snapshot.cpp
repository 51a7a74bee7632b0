// Stores the state of a stent as bytes in the machine's own byte order, for a replay on the same machine, as
// for the contrast medium.
#include "host/stent/stent.hpp"
#include <algorithm>
#include <cstring>
#include <type_traits>

namespace crn
{

namespace
{

using Eigen::Vector3d;

class Writer
{
  public:
    template <typename T> void operator()(const T &value)
    {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        bytes.resize(bytes.size() + sizeof value);
        std::memcpy(bytes.data() + bytes.size() - sizeof value, &value, sizeof value);
    }
    void operator()(const Vector3d &v)
    {
        for (int k = 0; k < 3; ++k) (*this)(v[k]);
    }
    std::vector<std::uint8_t> bytes;
};

class Reader
{
  public:
    explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    template <typename T> void operator()(T &value)
    {
        if (bytes_.size() - at_ < sizeof value) {
            is_short = true;
            return;
        }
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
    }
    void operator()(bool &value)
    {
        std::uint8_t byte = 0;
        (*this)(byte);
        value = byte != 0;
    }
    void operator()(Vector3d &v)
    {
        for (int k = 0; k < 3; ++k) (*this)(v[k]);
    }
    // A snapshot is refused if it contains numbers that are infinite, not a number, or far outside a patient.
    void operator()(double &value)
    {
        constexpr double largest = 1e4;
        double read = 0.0;
        operator()<double>(read);
        if (!(read >= -largest && read <= largest)) is_wrong = true;
        value = read;
    }
    bool is_at_end() const { return at_ == bytes_.size(); }
    std::size_t left() const { return bytes_.size() - at_; }
    bool is_short = false, is_wrong = false;

  private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

// The functions that write and read a snapshot both use this list of the state's members.
template <typename State, typename Visit> void visit_state(State &state, Visit &visit)
{
    visit(state.stage);
    visit(state.was_placed);
    visit(state.slip_mm);
    visit(state.across);
    for (auto &point : state.points) {
        visit(point.place_mm);
        visit(point.peak_mm);
        visit(point.foot.triangle);
        visit(point.foot.u);
        visit(point.foot.v);
        visit(point.foot.height_mm);
        visit(point.foot.distance_mm);
        visit(point.offset_mm);
        visit(point.layer_mm);
        visit(point.slid_mm);
        visit(point.is_bedded);
    }
    for (auto &rest : state.rest_mm) visit(rest);
    for (auto &centre : state.ring_centre_mm) visit(centre);
    for (auto *list : {&state.patch, &state.near_begin, &state.near})
        for (auto &item : *list) visit(item);
}

} // namespace

std::vector<std::uint8_t> Stent::snapshot() const
{
    Writer writer;
    const std::uint64_t counts[] = {state_.points.size(), state_.rest_mm.size(), state_.patch.size(),
                                    state_.near_begin.size(), state_.near.size()};
    for (std::uint64_t count : counts) writer(count);
    visit_state(state_, writer);
    return writer.bytes;
}

bool Stent::restore(std::span<const std::uint8_t> bytes)
{
    Reader reader(bytes);
    std::uint64_t points = 0, springs = 0, lists[3] = {};
    reader(points);
    reader(springs);
    std::uint64_t items = 0;
    for (std::uint64_t &list : lists) {
        reader(list);
        if (list > bytes.size()) return false;
        items += list;
    }
    if (reader.is_short || points != state_.points.size() || springs != state_.rest_mm.size() ||
        items > reader.left() / sizeof(std::uint32_t))
        return false;
    StentState state = state_;
    state.patch.resize(lists[0]);
    state.near_begin.resize(lists[1]);
    state.near.resize(lists[2]);
    visit_state(state, reader);
    if (reader.is_short || reader.is_wrong || !reader.is_at_end() || state.stage > StentStage::adrift)
        return false;
    state_ = std::move(state);
    return true;
}

bool Stent::fits(std::size_t triangle_count) const
{
    const auto is_below = [](std::size_t count) {
        return [=](std::uint32_t index) { return index < count; };
    };
    const std::vector<std::uint32_t> &begin = state_.near_begin;
    const bool has_list = !begin.empty();
    if (has_list && (begin.size() != lattice_.struts.size() + 1 || begin.back() != state_.near.size()))
        return false;
    return std::is_sorted(begin.begin(), begin.end()) &&
           std::all_of(state_.patch.begin(), state_.patch.end(), is_below(triangle_count)) &&
           std::all_of(state_.near.begin(), state_.near.end(), is_below(state_.patch.size())) &&
           std::all_of(state_.points.begin(), state_.points.end(), [&](const StentPoint &point) {
               return point.foot.triangle >= -1 &&
                      point.foot.triangle < static_cast<std::int64_t>(triangle_count);
           });
}

} // namespace crn
