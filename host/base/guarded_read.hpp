// Files that third-party parsers read are parsed in a child process with limits on memory, time and stack.
// The parsed data come back through a pipe as plain data, which the caller checks. A damaged file can end
// only the child process, and the error message says how the child ended.
//
//   caller                       child
//   read_apart -> fork ------->  limits, signals back to their defaults, no output but the pipe
//   take(Inbox)  <-- pipe -----  parse(Outbox)
//   waitpid      <-------------  ends, or is killed when its time is over
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace crn
{

// The message of a GuardedReadError begins with the file's name and gives the remedy.
struct GuardedReadError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// The limits of reading.
struct ReadLimits {
    std::uint64_t memory_bytes = 0; // memory that the child may use in addition to its parent's
    double cpu_s = 0;
    double wall_s = 0;
    std::uint64_t stack_bytes = std::uint64_t{8} << 20;
};

inline constexpr std::uint64_t read_memory_bytes_max = std::uint64_t{1900}
                                                       << 20; // with the parent below 2 GB

// Returns the limits of memory and time for reading a file of this size. The time limit is 18 s plus 2 s for
// each MiB of the file beyond 8 MiB; `growth` is the memory in bytes that each byte of the file may need.
ReadLimits read_limits(std::uint64_t file_bytes, double growth);

// The child process writes its data to the parent through an Outbox, which is the child's end of the pipe. If
// the child fails before it has written anything to the Outbox, its own message (a std::exception) reaches
// the parent.
class Outbox
{
  public:
    explicit Outbox(int pipe) : pipe_(pipe) {}
    void bytes(const void *bytes, std::size_t count);
    template <class Value> void value(const Value &value)
    {
        static_assert(std::is_trivially_copyable_v<Value>);
        bytes(&value, sizeof value);
    }
    void text(std::string_view text);
    template <class Value> void list(const std::vector<Value> &values)
    {
        static_assert(std::is_trivially_copyable_v<Value>);
        value<std::uint64_t>(values.size());
        bytes(values.data(), values.size() * sizeof(Value));
    }
    bool is_begun() const { return is_begun_; }

  private:
    int pipe_;
    bool is_begun_ = false;
};

// The parent process reads the child's data through an Inbox, which is the parent's end of the pipe. Every
// call of the Inbox throws GuardedReadError when the child ends, or exceeds its time, before it has sent
// enough data.
class Inbox
{
  public:
    Inbox(const std::string &file, const ReadLimits &limits);
    Inbox(const Inbox &) = delete;
    Inbox &operator=(const Inbox &) = delete;
    ~Inbox(); // ends the child if it is still there

    void bytes(void *bytes, std::size_t count);
    template <class Value> Value value()
    {
        Value value;
        static_assert(std::is_trivially_copyable_v<Value>);
        bytes(&value, sizeof value);
        return value;
    }
    // Reads at most `most` letters or values, because a faulty child process might announce more of them.
    std::string text(std::uint64_t most = 1 << 20);
    template <class Value> std::vector<Value> list(std::uint64_t most)
    {
        std::vector<Value> values(size(most));
        bytes(values.data(), values.size() * sizeof(Value));
        return values;
    }
    std::uint64_t size(std::uint64_t most);

  private:
    friend void read_apart(const std::string &, const ReadLimits &, const std::function<void(Outbox &)> &,
                           const std::function<void(Inbox &)> &);
    void start(const std::function<void(Outbox &)> &parse);
    void wait();      // until there is something to read; throws at the end of the child's time
    void finish();    // checks that nothing more comes, and that the child ended well
    void hear();      // collects the messages of its libraries
    void end_child(); // SIGKILL and waitpid
    [[noreturn]] void fail(const std::string &what);
    [[noreturn]] void fail_ended(); // with the reason of the child's end

    std::string file_, heard_;
    ReadLimits limits_;
    std::chrono::steady_clock::time_point began_;
    int child_ = -1, pipe_ = -1, noise_ = -1, status_ = 0;
};

// Runs `parse` in the child process and `take` in the parent process. Throws GuardedReadError or the
// exceptions of `take`; the child process has then ended.
void read_apart(const std::string &file, const ReadLimits &limits, const std::function<void(Outbox &)> &parse,
                const std::function<void(Inbox &)> &take);

// If a signal arrives while the parent waits for a child, the parent calls `is_wanted`. If `is_wanted`
// returns true, the reading of the file ends with the message "interrupted". A program whose Ctrl-C handler
// only sets a flag should register a function that returns this flag.
void stop_reading_when(bool (*is_wanted)());

// Returns the size of a regular file, for read_limits. Throws GuardedReadError if the file does not exist, is
// a folder, or has more than `most` bytes.
std::uint64_t regular_file_bytes(const std::string &file, std::uint64_t most);

} // namespace crn
