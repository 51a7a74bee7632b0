// Reading in a process of its own: Debian's GDCM is built with its assertions, and a damaged file may end the process that reads
// it. Here only the child ends, and the parent says which file is damaged.
#include "tools/ct/volume_io.hpp"
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace seld::ct
{

namespace
{

// What goes through the pipe before the values: numbers, then texts of these lengths.
struct Parcel {
    std::array<std::int32_t, 3> size{};
    double spacing_mm[3], origin_mm[3], direction[9];
    std::uint32_t fault_bytes = 0, notes_bytes = 0;
};

void send(int pipe, const void *bytes, std::size_t count)
{
    const char *at = static_cast<const char *>(bytes);
    while (count > 0) {
        const ssize_t sent = ::write(pipe, at, count);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) ::_exit(3); // the parent has gone
        at += sent;
        count -= static_cast<std::size_t>(sent);
    }
}

// False at the end of what was sent.
bool receive(int pipe, void *bytes, std::size_t count)
{
    char *at = static_cast<char *>(bytes);
    while (count > 0) {
        const ssize_t got = ::read(pipe, at, count);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got;
        count -= static_cast<std::size_t>(got);
    }
    return true;
}

[[noreturn]] void read_and_send(const std::filesystem::path &path, int pipe)
{
    Parcel parcel;
    Volume volume;
    std::string fault, notes;
    try {
        volume = read_volume_here(path);
    } catch (const std::exception &error) {
        fault = error.what();
        if (fault.empty()) fault = path.string() + ": cannot be read";
    }
    for (const std::string &note : volume.notes) notes += note + '\n';
    for (int i = 0; i < 3; ++i) {
        parcel.size[static_cast<std::size_t>(i)] = volume.size[static_cast<std::size_t>(i)];
        parcel.spacing_mm[i] = volume.spacing_mm[i];
        parcel.origin_mm[i] = volume.origin_mm[i];
    }
    std::memcpy(parcel.direction, volume.direction.data(), sizeof parcel.direction);
    parcel.fault_bytes = static_cast<std::uint32_t>(fault.size());
    parcel.notes_bytes = static_cast<std::uint32_t>(notes.size());
    send(pipe, &parcel, sizeof parcel);
    send(pipe, fault.data(), fault.size());
    send(pipe, notes.data(), notes.size());
    send(pipe, volume.hu.data(), volume.hu.size() * sizeof(float));
    ::_exit(0);
}

bool unpack(int pipe, Volume &volume, std::string &fault)
{
    Parcel parcel;
    if (!receive(pipe, &parcel, sizeof parcel)) return false;
    fault.resize(parcel.fault_bytes);
    std::string notes(parcel.notes_bytes, ' ');
    if (!receive(pipe, fault.data(), fault.size()) || !receive(pipe, notes.data(), notes.size()))
        return false;
    if (!fault.empty()) return true;
    for (int i = 0; i < 3; ++i) {
        volume.size[static_cast<std::size_t>(i)] = parcel.size[static_cast<std::size_t>(i)];
        volume.spacing_mm[i] = parcel.spacing_mm[i];
        volume.origin_mm[i] = parcel.origin_mm[i];
    }
    std::memcpy(volume.direction.data(), parcel.direction, sizeof parcel.direction);
    for (std::size_t begin = 0, end; (end = notes.find('\n', begin)) != std::string::npos; begin = end + 1)
        volume.notes.push_back(notes.substr(begin, end - begin));
    volume.hu.resize(volume.count());
    return receive(pipe, volume.hu.data(), volume.hu.size() * sizeof(float));
}

} // namespace

Volume read_volume(const std::filesystem::path &path)
{
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw Fault(path.string() + ": no pipe: " + std::strerror(errno));
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child < 0) throw Fault(path.string() + ": no process for reading: " + std::strerror(errno));
    if (child == 0) {
        // What the libraries say on the terminal is in the message already.
        const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
        ::dup2(nowhere, STDOUT_FILENO);
        ::dup2(nowhere, STDERR_FILENO);
        ::close(ends[0]);
        read_and_send(path, ends[1]);
    }
    ::close(ends[1]);
    Volume volume;
    volume.name = path.string();
    std::string fault;
    const bool is_whole = unpack(ends[0], volume, fault);
    ::close(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!fault.empty()) throw Fault(fault);
    if (!is_whole)
        throw Fault(path.string() + ": is damaged in a way that ends its reader (" +
                    (WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "it stopped") +
                    "): export it again");
    return volume;
}

} // namespace seld::ct
