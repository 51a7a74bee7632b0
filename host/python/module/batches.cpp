// Advances many worlds together over a pool of threads; cournand.envs uses this code. One call moves the
// worlds, reads them into arrays, and renders them; no Python code runs in between. The results of a world do
// not depend on the number of threads. Only one thread at a time can use a batch.
#include "host/python/module/pictures.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <nanobind/stl/array.h>

namespace cournand_python
{

namespace
{

// The numbers of one world in `states` are: points of the leading tip's shape; then, for each of
// three positions, the inserted length and the force and torque of the hand; then the values that FIGURES in
// cournand/batch.py names.
constexpr std::size_t figures = 8, of_hands = 9;
constexpr std::uint32_t points_max = 1000;
constexpr std::size_t count_max = 1'000'000;

std::uint32_t within(std::uint32_t points, std::size_t count)
{
    if (points > points_max || count > count_max)
        throw nb::value_error("a batch has at most a million worlds, and 1000 points of each");
    return points;
}

Pool *create_pool(std::uint32_t threads)
{
    cournand_pool *pool = nullptr;
    unlocked([&] { return cournand_pool_create(threads, &pool); });
    return new Pool(pool);
}

// Keeps the status and the text of each call in a pool, because the library keeps texts separately for each
// thread.
class Outcomes
{
  public:
    explicit Outcomes(std::size_t count) : statuses_(count), texts_(count) {}
    void take(std::size_t index, cournand_status status)
    {
        statuses_[index] = status;
        if (status != COURNAND_OK) texts_[index] = cournand_error_text();
    }
    void throw_first() const
    {
        for (std::size_t i = 0; i < statuses_.size(); i++)
            if (statuses_[i] != COURNAND_OK) throw StatusError(statuses_[i], texts_[i]);
    }

  private:
    std::vector<cournand_status> statuses_;
    std::vector<std::string> texts_;
};

cournand_status save_of(cournand_world *world, std::vector<std::uint8_t> &bytes)
{
    std::size_t count = 0;
    if (const auto status = cournand_world_snapshot_bytes(world, &count)) return status;
    bytes.resize(count);
    return cournand_world_save(world, bytes.data(), bytes.size());
}

class Batch
{
  public:
    Batch(nb::object pool, std::size_t count, std::uint32_t points, double spacing_m)
        : pool_(std::move(pool)), threads_(nb::cast<const Pool &>(pool_).get()), count_(count),
          points_(within(points, count)), spacing_m_(spacing_m), width_(points * 3 + of_hands + figures),
          worlds_(count), states_(count * width_), places_(count * 4), vessels_(count, -1)
    {
    }

    void put(std::size_t index, nb::object world)
    {
        nb::cast<const World &>(world);
        worlds_.at(index) = std::move(world);
    }

    void step(const Given<float> &actions, std::uint32_t ticks, const std::vector<std::size_t> &which);
    void observe(const std::vector<std::size_t> &which);
    void restore(const std::vector<nb::bytes> &snapshots, const std::vector<std::size_t> &which);
    void render(const nb::list &renderers, const std::vector<ViewNumbers> &views, std::uint32_t flags,
                const std::vector<std::uint64_t> &seeds, const std::vector<std::size_t> &which);

    nb::object states(nb::handle self) const { return view(states_.data(), {count_, width_}, self); }
    nb::object places(nb::handle self) const { return view(places_.data(), {count_, 4}, self); }
    nb::object vessels(nb::handle self) const { return view(vessels_.data(), {count_}, self); }
    nb::object grey(nb::handle self) const { return pictures(grey_, self); }
    nb::object labels(nb::handle self) const { return pictures(labels_, self); }

  private:
    // A call from a second thread is refused, because it would overwrite the arrays that the first thread
    // reads.
    class Inside
    {
      public:
        explicit Inside(std::atomic_flag &is_busy) : is_busy_(is_busy)
        {
            if (is_busy_.test_and_set(std::memory_order_acquire))
                throw StatusError(COURNAND_BUSY, "another thread is inside this batch: wait for it");
        }
        ~Inside() { is_busy_.clear(std::memory_order_release); }
        Inside(const Inside &) = delete;
        Inside &operator=(const Inside &) = delete;

      private:
        std::atomic_flag &is_busy_;
    };

    nb::object pictures(const std::vector<std::uint8_t> &pixels, nb::handle self) const
    {
        if (size_ == 0 || pixels.empty()) return nb::none();
        return view(pixels.data(), {count_, size_, size_}, self);
    }
    cournand_world *world(std::size_t index) const
    {
        const nb::object &one = worlds_.at(index);
        if (!one.is_valid()) throw nb::value_error("the batch has no world at this number: put one there");
        return nb::cast<const World &>(one).get();
    }
    std::vector<cournand_world *> handles(const std::vector<std::size_t> &which) const
    {
        std::vector<cournand_world *> found;
        for (const std::size_t index : which) found.push_back(world(index));
        auto sorted = which;
        std::sort(sorted.begin(), sorted.end());
        if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
            throw nb::value_error("a world is named twice");
        return found;
    }
    cournand_status read(std::size_t index, cournand_world *world);
    cournand_status read_points(cournand_world *world, float *to);
    // Calls work(i) for each i below `count` in the pool, without the interpreter's lock, and throws the
    // first refusal, if any.
    template <class Work> void run(std::size_t count, const Work &work);
    void read_all(const std::vector<std::size_t> &which, const std::vector<cournand_world *> &worlds);

    nb::object pool_;
    cournand_pool *threads_;
    std::size_t count_;
    std::uint32_t points_;
    double spacing_m_;
    std::size_t width_;
    std::vector<nb::object> worlds_;
    std::atomic_flag is_busy_ = ATOMIC_FLAG_INIT;
    // The arrays are allocated once for each size of pictures, so that views of them stay valid.
    std::vector<float> states_, places_;
    std::vector<std::int32_t> vessels_;
    std::vector<std::uint8_t> grey_, labels_;
    std::size_t size_ = 0; // of the pictures; 0 before the first ones
};

template <class Work> void Batch::run(std::size_t count, const Work &work)
{
    struct Task {
        const Work *work;
        Outcomes outcomes;
    } task{&work, Outcomes(count)};
    const nb::gil_scoped_release release;
    const auto one = [](void *context, std::size_t i) {
        Task &todo = *static_cast<Task *>(context);
        todo.outcomes.take(i, (*todo.work)(i));
    };
    check(cournand_pool_run(threads_, count, one, &task));
    task.outcomes.throw_first();
}

void Batch::read_all(const std::vector<std::size_t> &which, const std::vector<cournand_world *> &worlds)
{
    run(which.size(), [&](std::size_t i) { return read(which[i], worlds[i]); });
}

// Interpolates the positions of equally spaced points along the shape, beginning at the leading tip.
cournand_status Batch::read_points(cournand_world *world, float *to)
{
    auto pose = sized<cournand_pose>();
    if (const auto status = cournand_world_pose(world, &pose)) return status;
    std::uint32_t node = 0;
    for (std::uint32_t p = 0; p < points_; p++) {
        const auto arc = static_cast<float>(p * spacing_m_);
        while (node + 2 < pose.node_count && pose.arcs_m[node + 1] < arc) node++;
        const float *from = pose.positions_m + 3 * node, length = pose.arcs_m[node + 1] - pose.arcs_m[node];
        const float part = length > 0 ? std::clamp((arc - pose.arcs_m[node]) / length, 0.0f, 1.0f) : 0.0f;
        for (int axis = 0; axis < 3; axis++)
            to[3 * p + axis] = from[axis] + part * (from[3 + axis] - from[axis]);
    }
    return COURNAND_OK;
}

cournand_status Batch::read(std::size_t index, cournand_world *world)
{
    float *to = states_.data() + index * width_;
    if (const auto status = read_points(world, to)) return status;
    to += 3 * points_;
    auto r = sized<cournand_reading>();
    if (const auto status = cournand_world_read(world, &r)) return status;
    for (int k = 0; k < COURNAND_POSITIONS_MAX; k++) {
        *to++ = r.inserted_m[k];
        *to++ = r.force_N[k];
        *to++ = r.torque_N_m[k];
    }
    for (const float number :
         {r.wall_force_N, r.wall_force_peak_N, r.penetration_m, r.length_error, r.heart_phase, r.breath_phase,
          static_cast<float>(r.contact_count), static_cast<float>(r.is_out_of_range)})
        *to++ = number;
    auto place = sized<cournand_place>();
    if (const auto status = cournand_world_tip(world, 0, &place)) return status;
    vessels_[index] = place.vessel;
    float *at = places_.data() + 4 * index;
    for (const double number : {place.along_m, place.inside_m, place.radii, 0.0})
        *at++ = static_cast<float>(number);
    return COURNAND_OK;
}

void Batch::step(const Given<float> &actions, std::uint32_t ticks, const std::vector<std::size_t> &which)
{
    if (actions.shape(0) != which.size() || actions.shape(1) != COURNAND_ACTION_FLOATS)
        throw nb::value_error("actions has one row of 8 numbers per world");
    const Inside inside(is_busy_);
    const auto worlds = handles(which);
    // Works on a copy, because the caller may write to its array meanwhile, and could then change values that
    // were already checked.
    const std::vector<float> rows(actions.data(), actions.data() + actions.size());
    Outcomes outcomes(which.size());
    auto reads = [&](std::size_t i) { outcomes.take(i, read(which[i], worlds[i])); };
    using Reads = decltype(reads);
    const auto one = [](void *context, std::size_t i) { (*static_cast<Reads *>(context))(i); };
    unlocked([&] {
        return cournand_pool_step(threads_, worlds.data(), worlds.size(), rows.data(), ticks, one, &reads,
                                  nullptr);
    });
    outcomes.throw_first();
}

void Batch::observe(const std::vector<std::size_t> &which)
{
    const Inside inside(is_busy_);
    read_all(which, handles(which));
}

void Batch::restore(const std::vector<nb::bytes> &snapshots, const std::vector<std::size_t> &which)
{
    if (snapshots.size() != which.size()) throw nb::value_error("there is one snapshot per world");
    const Inside inside(is_busy_);
    const auto worlds = handles(which);
    struct Bytes {
        const void *data;
        std::size_t size;
    };
    std::vector<Bytes> bytes;
    for (const nb::bytes &one : snapshots) bytes.push_back({one.data(), one.size()});
    std::vector<std::vector<std::uint8_t>> before(which.size());
    run(which.size(), [&](std::size_t i) { return save_of(worlds[i], before[i]); });
    const auto take = [&](std::size_t i, const void *data, std::size_t size) {
        const auto status = cournand_world_restore(worlds[i], data, size);
        return status ? status : read(which[i], worlds[i]);
    };
    try {
        run(which.size(), [&](std::size_t i) { return take(i, bytes[i].data, bytes[i].size); });
    } catch (const StatusError &) {
        // If a world refuses to save its present state (because it is recorded), it has already refused the
        // snapshot, too.
        run(which.size(), [&](std::size_t i) {
            take(i, before[i].data(), before[i].size());
            return COURNAND_OK;
        });
        throw;
    }
}

// If a batch has one renderer per world, each renderer keeps its world's view, which makes pictures of
// unchanged views faster; with fewer renderers, worlds share them. The pictures do not depend on which
// renderer makes them.
void Batch::render(const nb::list &renderers, const std::vector<ViewNumbers> &views, std::uint32_t flags,
                   const std::vector<std::uint64_t> &seeds, const std::vector<std::size_t> &which)
{
    if (views.size() != which.size() || seeds.size() != which.size() || renderers.size() == 0)
        throw nb::value_error("there is one view and one seed per world, and at least one renderer");
    const Inside inside(is_busy_);
    const auto worlds = handles(which);
    std::vector<cournand_renderer *> all;
    for (const nb::handle one : renderers) all.push_back(nb::cast<const Renderer &>(one).get());
    const bool is_own = all.size() == count_;
    std::vector<cournand_renderer *> idle = all;
    const std::uint32_t size = nb::cast<const Renderer &>(renderers[0]).size();
    for (const nb::handle one : renderers)
        if (nb::cast<const Renderer &>(one).size() != size) throw nb::value_error("renderers differ in size");
    if (size_ != 0 && size_ != size) throw nb::value_error("a batch has pictures of one size");
    if (size_ == 0) { // an earlier call may have been refused after it had taken memory
        grey_.clear();
        labels_.clear();
    }
    const std::size_t pixels = std::size_t{size} * size;
    if (grey_.empty() && !(flags & COURNAND_VIEW_LABELS_ONLY)) grey_.resize(count_ * pixels);
    if (labels_.empty() && (flags & (COURNAND_VIEW_LABELS | COURNAND_VIEW_LABELS_ONLY)))
        labels_.resize(count_ * pixels);
    std::mutex mutex;
    std::condition_variable returned;
    run(which.size(), [&](std::size_t i) {
        cournand_renderer *renderer = is_own ? all[which[i]] : nullptr;
        if (!is_own) {
            std::unique_lock lock(mutex);
            returned.wait(lock, [&] { return !idle.empty(); });
            renderer = idle.back();
            idle.pop_back();
        }
        const cournand_view view = make_view(views[i], size, flags, seeds[i]);
        auto picture = sized<cournand_picture>();
        const auto status = cournand_render(renderer, worlds[i], &view, &picture);
        if (picture.grey) std::copy_n(picture.grey, pixels, grey_.data() + which[i] * pixels);
        if (picture.labels) std::copy_n(picture.labels, pixels, labels_.data() + which[i] * pixels);
        if (!is_own) {
            const std::lock_guard lock(mutex);
            idle.push_back(renderer);
            returned.notify_one();
        }
        return status;
    });
    size_ = size;
}

} // namespace

void add_batches(nb::module_ &module)
{
    nb::class_<Pool>(module, "Pool").def(nb::new_(&create_pool), nb::arg("threads"));
    nb::class_<Batch>(module, "Batch")
        .def(nb::init<nb::object, std::size_t, std::uint32_t, double>())
        .def("put", &Batch::put)
        .def("step", &Batch::step)
        .def("observe", &Batch::observe)
        .def("restore", &Batch::restore)
        .def("render", &Batch::render)
        .def("states", [](nb::handle_t<Batch> self) { return nb::cast<Batch &>(self).states(self); })
        .def("places", [](nb::handle_t<Batch> self) { return nb::cast<Batch &>(self).places(self); })
        .def("vessels", [](nb::handle_t<Batch> self) { return nb::cast<Batch &>(self).vessels(self); })
        .def("grey", [](nb::handle_t<Batch> self) { return nb::cast<Batch &>(self).grey(self); })
        .def("labels", [](nb::handle_t<Batch> self) { return nb::cast<Batch &>(self).labels(self); });
}

} // namespace cournand_python
