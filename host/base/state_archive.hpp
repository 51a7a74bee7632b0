// Saves the state of an object as bytes, and restores the state from bytes. A class lists its members once,
// for both directions:
//
//   void Injector::archive(StateArchive &state)
//   {
//       state.list(injections_, [&](Injection &one) { state.integer(one.tick); ... });
//       state.real(flow_ml_s_, 0.0, 50.0);
//   }
//
// The bytes have the byte order of the machine that saved them. The bytes may come from any source: the
// archive is refused if a value is outside its limits, or if the bytes end too early. After the archive is
// refused, it changes no further value. If the archive is refused, the object has an undefined state, and its
// owner must restore another state.
#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace crn
{

class StateArchive
{
  public:
    // Returns an archive that saves a state by appending it to `bytes`.
    static StateArchive saving(std::vector<std::uint8_t> &bytes)
    {
        StateArchive archive;
        archive.to_ = &bytes;
        return archive;
    }
    static StateArchive restoring(std::span<const std::uint8_t> bytes)
    {
        StateArchive archive;
        archive.from_ = bytes;
        return archive;
    }

    bool restores() const { return to_ == nullptr; }
    bool is_refused() const { return is_refused_; }
    bool is_at_end() const { return from_.empty(); } // of the bytes from which the archive restores
    // Marks the archive as refused if a condition on restored values does not hold.
    void require(bool holds) { is_refused_ = is_refused_ || !holds; }

    template <std::integral Number>
    void integer(Number &value, Number least = std::numeric_limits<Number>::min(),
                 Number most = std::numeric_limits<Number>::max())
    {
        static_assert(!std::same_as<Number, bool>);
        Number read = value;
        raw(&read, sizeof read);
        if (restores()) require(read >= least && read <= most);
        if (!is_refused_) value = read;
    }
    // A count or an index has 8 bytes on every machine.
    void index(std::size_t &value, std::size_t below)
    {
        std::uint64_t read = value;
        integer(read);
        if (restores()) require(read < below);
        if (!is_refused_) value = static_cast<std::size_t>(read);
    }
    // Also refuses numbers that are infinite or not a number.
    template <std::floating_point Real> void real(Real &value, double least = -largest, double most = largest)
    {
        Real read = value;
        raw(&read, sizeof read);
        if (restores()) require(read >= least && read <= most);
        if (!is_refused_) value = read;
    }
    void reals(std::span<double> values, double least = -largest, double most = largest)
    {
        for (double &value : values) real(value, least, most);
    }
    void flag(bool &value)
    {
        std::uint8_t byte = value ? 1 : 0;
        integer<std::uint8_t>(byte, 0, 1);
        value = byte != 0;
    }
    template <class Kind> void choice(Kind &value, Kind last)
    {
        static_assert(std::is_enum_v<Kind>);
        auto number = static_cast<std::int32_t>(value);
        integer<std::int32_t>(number, 0, static_cast<std::int32_t>(last));
        value = static_cast<Kind>(number);
    }
    void text(std::string &value)
    {
        std::size_t size = value.size();
        index(size, text_bytes_max + 1);
        if (restores()) require(size <= from_.size());
        if (is_refused_) return;
        std::string read = value;
        read.resize(size);
        raw(read.data(), size);
        // A text must have no control characters, because it is shown on one line.
        for (const char letter : read) require(static_cast<unsigned char>(letter) >= 0x20 && letter != 0x7f);
        if (!is_refused_) value = std::move(read);
    }
    // Calls each(item) for every item of the list; when restoring, the list first gets the saved number of
    // items.
    template <class List, class Each> void list(List &items, Each each)
    {
        std::size_t count = items.size();
        index(count, std::numeric_limits<std::size_t>::max());
        if (restores()) require(count <= from_.size()); // every item has at least one byte
        if (is_refused_) return;
        if (restores()) {
            items.clear();
            items.resize(count);
        }
        for (auto &item : items) {
            if (is_refused_) return;
            each(item);
        }
    }
    template <class Value, class Each> void optional(std::optional<Value> &value, Each each)
    {
        bool has_value = value.has_value();
        flag(has_value);
        if (is_refused_) return;
        if (restores()) value = has_value ? std::optional<Value>(Value{}) : std::nullopt;
        if (value) each(*value);
    }
    // Saves or restores bytes of another format, preceded by their number.
    void bytes(std::vector<std::uint8_t> &value)
    {
        std::size_t size = value.size();
        index(size, std::numeric_limits<std::size_t>::max());
        if (restores()) require(size <= from_.size());
        if (is_refused_) return;
        value.resize(size);
        raw(value.data(), size);
    }

  private:
    static constexpr double largest = 1e15;
    static constexpr std::size_t text_bytes_max = 4096;

    StateArchive() = default;
    void raw(void *value, std::size_t size)
    {
        if (size == 0) return;
        if (to_) {
            const std::size_t at = to_->size();
            to_->resize(at + size);
            std::memcpy(to_->data() + at, value, size);
            return;
        }
        require(size <= from_.size());
        if (is_refused_) return;
        std::memcpy(value, from_.data(), size);
        from_ = from_.subspan(size);
    }

    std::vector<std::uint8_t> *to_ = nullptr; // null: the archive restores
    std::span<const std::uint8_t> from_;
    bool is_refused_ = false;
};

} // namespace crn
