#include "host/command/cli_dicom.hpp"
#include "host/base/command_values.hpp"
#include "host/base/output_files.hpp"
#include "host/base/terminal.hpp"
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/wait.h>
#include <unistd.h>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr int exit_no_program = 127;

struct Verdict {
    std::string kind; // "XAImage", dciodvfy's name for the recognised kind; empty: not recognised
    std::vector<std::string> errors, warnings;
};

[[noreturn]] void become_dciodvfy(int output, const std::string &file)
{
    const int nothing = ::open("/dev/null", O_RDONLY);
    if (nothing < 0 || ::dup2(nothing, 0) < 0 || ::dup2(output, 1) < 0 || ::dup2(output, 2) < 0) ::_exit(1);
    ::execlp("dciodvfy", "dciodvfy", file.c_str(), static_cast<char *>(nullptr));
    ::_exit(exit_no_program);
}

std::string read_all(int from)
{
    std::string text;
    char piece[4096];
    for (;;) {
        const ssize_t count = ::read(from, piece, sizeof piece);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return text;
        text.append(piece, static_cast<std::size_t>(count));
    }
}

// Runs dciodvfy (a checker of DICOM files) on one file and returns its messages; the exit code of dciodvfy is
// meaningless. Throws std::runtime_error when dciodvfy cannot be run.
std::string ask_dciodvfy(const std::string &file)
{
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        throw std::runtime_error("cannot make a pipe: " + std::string(std::strerror(errno)));
    const pid_t process = ::fork();
    // If a file name began with a dash, dciodvfy would read it as an option.
    if (process == 0) become_dciodvfy(ends[1], file[0] == '-' ? "./" + file : file);
    ::close(ends[1]);
    const std::string text = process > 0 ? read_all(ends[0]) : "";
    ::close(ends[0]);
    int status = 0;
    while (process > 0 && ::waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    if (process > 0 && WIFEXITED(status) && WEXITSTATUS(status) != exit_no_program) return text;
    if (process > 0 && WIFSIGNALED(status)) throw std::runtime_error(file + ": dciodvfy crashed on it");
    throw std::runtime_error(
        "the program dciodvfy was not found; install it (Debian: apt-get install dicom3tools)");
}

Verdict verdict_of(const std::string &text)
{
    Verdict verdict;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        const std::string line = text.substr(begin, end - begin);
        begin = end + 1;
        if (line.find("Error -") != line.npos || line.find("Abort -") != line.npos)
            verdict.errors.push_back(line);
        else if (line.find("Warning -") != line.npos)
            verdict.warnings.push_back(line);
        else if (verdict.kind.empty() && !line.empty() && line.find(' ') == line.npos)
            verdict.kind = line;
    }
    if (verdict.kind.empty() && verdict.errors.empty())
        verdict.errors.push_back("Error - dciodvfy recognised nothing");
    return verdict;
}

// Replaces every folder in the list by the .dcm files in it, sorted by name.
std::vector<std::string> files_of(const std::vector<std::string> &named)
{
    std::vector<std::string> files;
    for (const std::string &name : named) {
        std::error_code failed;
        const fs::file_status status = fs::status(name, failed);
        if (!fs::exists(status)) throw std::runtime_error(name + ": no such file or folder");
        if (!fs::is_directory(status)) {
            if (std::FILE *file = std::fopen(name.c_str(), "rb"))
                std::fclose(file);
            else
                throw std::runtime_error(name + ": cannot be read: " + std::strerror(errno));
            files.push_back(name);
            continue;
        }
        std::vector<std::string> inside;
        for (const fs::directory_entry &entry : fs::directory_iterator(name))
            if (entry.path().extension() == ".dcm") inside.push_back(entry.path().string());
        if (inside.empty()) throw std::runtime_error(name + ": no .dcm file in this folder");
        std::sort(inside.begin(), inside.end());
        files.insert(files.end(), inside.begin(), inside.end());
    }
    return files;
}

std::string counted(std::size_t count, const char *what)
{
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

} // namespace

void add_dicom_options(CLI::App &command, DicomSettings &settings)
{
    CLI::Option *folder =
        command
            .add_option(
                "--dicom", settings.folder,
                "Write every run (pedal down to pedal up) as a DICOM XA file into this folder, which may not "
                "hold .dcm files yet; anonymous")
            ->type_name("FOLDER")
            ->group("Outputs");
    command
        .add_option("--dicom-values", settings.values,
                    "What the pixels are: log or linear in the X-ray intensity, or display, as on the screen "
                    "(docs/output.md)")
        ->capture_default_str()
        ->check(one_of({"log", "linear", "display"}))
        ->needs(folder)
        ->group("DICOM");
    command.add_option("--patient-name", settings.patient_name, "Name in the DICOM files, as Family^Given")
        ->needs(folder)
        ->group("DICOM");
    command.add_option("--patient-id", settings.patient_id, "Patient's number in the DICOM files")
        ->needs(folder)
        ->group("DICOM");
    command
        .add_option("--study-date", settings.study_date, "Date in the DICOM files, YYYYMMDD; default: none")
        ->needs(folder)
        ->group("DICOM");
}

void add_dicom_check(CLI::App &app, DicomCheckOptions &options)
{
    CLI::App *command = app.add_subcommand(
        "dicom-check",
        "Check DICOM files by dciodvfy (Debian package dicom3tools); exit code 1 when it finds errors");
    command->add_option("file", options.files, "DICOM files, or folders of .dcm files")
        ->type_name("FILE")
        ->required();
    command->add_flag("--warnings", options.shows_warnings, "List the warnings too, not only their number");
    command->footer("Examples:\n  cournand dicom-check out/dicom\n"
                    "  cournand dicom-check --warnings out/dicom/run_01_fluoro.dcm");
}

int command_dicom_check(const DicomCheckOptions &options)
{
    std::size_t errors = 0, warnings = 0;
    const std::vector<std::string> files = files_of(options.files);
    for (const std::string &file : files) {
        const Verdict verdict = verdict_of(ask_dciodvfy(file));
        say(stdout, "%s: %s, %s, %s\n", file.c_str(),
            verdict.kind.empty() ? "not recognised" : verdict.kind.c_str(),
            counted(verdict.errors.size(), "error").c_str(),
            counted(verdict.warnings.size(), "warning").c_str());
        for (const std::string &line : verdict.errors) say(stdout, "  %s\n", line.c_str());
        if (options.shows_warnings)
            for (const std::string &line : verdict.warnings) say(stdout, "  %s\n", line.c_str());
        std::fflush(stdout);
        errors += verdict.errors.size();
        warnings += verdict.warnings.size();
    }
    say(stdout, "%s: %s, %s\n", counted(files.size(), "file").c_str(), counted(errors, "error").c_str(),
        counted(warnings, "warning").c_str());
    return errors == 0 ? 0 : 1;
}

} // namespace crn
