// Stores records in one SQLite file: with a write-ahead log, every commit flushed to the disk (synchronous
// FULL), and deleted bytes overwritten (secure_delete). The settings of SQLite apply to one connection, so
// they are set whenever the file is opened.
#include "host/base/terminal.hpp"
#include "host/records/database.hpp"
#include "host/records/identity.hpp"
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

namespace crn
{

namespace
{

namespace fs = std::filesystem;
using Cause = RecordsError::Cause;

constexpr int busy_ms = 10000;
constexpr std::int64_t application_id = 0x43524e44; // "CRND", in the header of the file

// Returns the remedy for a cause that SQLite reports; `system_error` is errno of the failed call, or 0.
RecordsError error_of(const std::string &path, int code, int system_error, const std::string &text)
{
    const std::string begin = printable(path) + ": ";
    // SQLite reports ENOSPC as FULL, but a quota (EDQUOT) or a limit of the file's size (EFBIG) only as a
    // failed write.
    if ((code & 0xff) == SQLITE_FULL || code == SQLITE_IOERR_WRITE || code == SQLITE_IOERR_SHMSIZE)
        return {Cause::no_space, begin +
                                     "the disk is full or a quota is used up, so nothing was stored; earlier "
                                     "records are unchanged. Free some space, then repeat the command"};
    switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return {Cause::busy, begin + "another program has kept these records locked for " +
                                 std::to_string(busy_ms / 1000) +
                                 " s, so nothing was stored; end the other program, then repeat the command"};
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return {Cause::damaged,
                begin + "this is not a whole SQLite file (" + text +
                    "). Put a backup in its place, or move the file away, so that a new one is "
                    "begun; `sqlite3 FILE .recover` may save parts of the old one"};
    case SQLITE_READONLY:
    case SQLITE_PERM:
        return {Cause::refused, begin + "the records cannot be written: " + text +
                                    "; you need to own the file and its folder"};
    case SQLITE_CANTOPEN:
        return {Cause::refused, begin + "the records cannot be opened: " +
                                    (system_error ? std::strerror(system_error) : text) +
                                    "; name a file in a folder that you can write to by --records"};
    default:
        return {Cause::refused, begin + "SQLite: " + text};
    }
}

RecordsError error_of_system(const std::string &path, int system_error)
{
    const bool has_no_space = system_error == ENOSPC || system_error == EDQUOT || system_error == EFBIG;
    return error_of(path, has_no_space ? SQLITE_FULL : SQLITE_CANTOPEN, system_error, "");
}

class Statement
{
  public:
    Statement(sqlite3 *file, const std::string &path, const std::string &text) : file_(file), path_(path)
    {
        check(sqlite3_prepare_v2(file, text.c_str(), -1, &statement_, nullptr));
    }
    ~Statement() { sqlite3_finalize(statement_); }
    Statement(const Statement &) = delete;
    Statement &operator=(const Statement &) = delete;

    // SQLite numbers the parameters "$1", "$2" by their first occurrence in the statement, so each
    // parameter's index is looked up by its name.
    void bind(const std::vector<SqlValue> &values)
    {
        for (std::size_t i = 0; i < values.size(); i++) {
            const int place = sqlite3_bind_parameter_index(statement_, ("$" + std::to_string(i + 1)).c_str());
            if (place > 0) bind_one(place, values[i]);
        }
    }

    SqlResult run()
    {
        SqlResult result;
        int code;
        while ((code = sqlite3_step(statement_)) == SQLITE_ROW) {
            SqlRow row;
            for (int column = 0; column < sqlite3_column_count(statement_); column++)
                row.push_back(value(column));
            result.rows.push_back(std::move(row));
        }
        if (code != SQLITE_DONE) check(code);
        if (!sqlite3_stmt_readonly(statement_)) result.changed = sqlite3_changes64(file_);
        return result;
    }

  private:
    sqlite3 *file_;
    const std::string &path_;
    sqlite3_stmt *statement_ = nullptr;

    void check(int code)
    {
        if (code != SQLITE_OK)
            throw error_of(path_, code, sqlite3_system_errno(file_), sqlite3_errmsg(file_));
    }

    void bind_one(int place, const SqlValue &value)
    {
        if (const auto *whole = std::get_if<std::int64_t>(&value))
            check(sqlite3_bind_int64(statement_, place, *whole));
        else if (const auto *number = std::get_if<double>(&value))
            check(sqlite3_bind_double(statement_, place, *number));
        else if (const auto *text = std::get_if<std::string>(&value))
            check(sqlite3_bind_text(statement_, place, text->data(), static_cast<int>(text->size()),
                                    SQLITE_TRANSIENT));
        else
            check(sqlite3_bind_null(statement_, place));
    }

    SqlValue value(int column)
    {
        switch (sqlite3_column_type(statement_, column)) {
        case SQLITE_INTEGER:
            return std::int64_t{sqlite3_column_int64(statement_, column)};
        case SQLITE_FLOAT:
            return sqlite3_column_double(statement_, column);
        case SQLITE_NULL:
            return {};
        default:
            break;
        }
        const unsigned char *text = sqlite3_column_text(statement_, column);
        return std::string(reinterpret_cast<const char *>(text),
                           static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
    }
};

class SqliteDatabase : public Database
{
  public:
    explicit SqliteDatabase(const std::string &path) : path_(path)
    {
        create_private();
        const int code = sqlite3_open_v2(path.c_str(), &file_, SQLITE_OPEN_READWRITE, nullptr);
        if (code != SQLITE_OK) {
            const RecordsError error = error_of(path_, code, file_ ? sqlite3_system_errno(file_) : ENOMEM,
                                                file_ ? sqlite3_errmsg(file_) : "out of memory");
            sqlite3_close(file_);
            throw error;
        }
        try {
            sqlite3_extended_result_codes(file_, 1);
            sqlite3_busy_timeout(file_, busy_ms);
            check_kind();
            for (const char *setting :
                 {"PRAGMA journal_mode=WAL", "PRAGMA synchronous=FULL", "PRAGMA foreign_keys=ON",
                  "PRAGMA secure_delete=ON", "PRAGMA trusted_schema=OFF"})
                run(setting);
        } catch (...) {
            sqlite3_close(file_);
            throw;
        }
    }
    ~SqliteDatabase() override { sqlite3_close(file_); }

    SqlResult run(const std::string &text, const std::vector<SqlValue> &values) override
    {
        Statement statement(file_, path_, text);
        statement.bind(values);
        return statement.run();
    }
    SqlResult run(const std::string &text) { return run(text, {}); }

    void run_all(const std::string &statements) override
    {
        const int code = sqlite3_exec(file_, statements.c_str(), nullptr, nullptr, nullptr);
        if (code != SQLITE_OK)
            throw error_of(path_, code, sqlite3_system_errno(file_), sqlite3_errmsg(file_));
    }

    void begin() override { run("BEGIN IMMEDIATE"); }
    void commit() override { run("COMMIT"); }
    void roll_back() noexcept override
    {
        // If the disk was full, SQLite may have rolled back already; the statement ROLLBACK then fails and
        // changes nothing.
        sqlite3_exec(file_, "ROLLBACK", nullptr, nullptr, nullptr);
    }

    int version() override { return static_cast<int>(whole_of(run("PRAGMA user_version").rows.at(0).at(0))); }
    void set_version(int version) override
    {
        run("PRAGMA application_id=" + std::to_string(application_id));
        run("PRAGMA user_version=" + std::to_string(version));
    }
    void lock(const std::string &) override {} // BEGIN IMMEDIATE has locked the file

    std::string back_up(const std::string &reason) override
    {
        const std::string copy = path_ + "." + reason + "." + utc_now();
        const int file = ::open(copy.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        if (file < 0) throw error_of_system(copy, errno);
        ::close(file);
        try {
            run("VACUUM INTO $1", {copy});
        } catch (...) {
            ::unlink(copy.c_str());
            throw;
        }
        return copy;
    }

    void forget_deleted() override
    {
        run("PRAGMA wal_checkpoint(TRUNCATE)");
        run("VACUUM");
        run("PRAGMA wal_checkpoint(TRUNCATE)");
        // A copy of the database from before a migration still has the erased data.
        std::error_code ignored;
        const fs::path path = fs::absolute(path_, ignored);
        const std::string begin = path.filename().string() + ".before_version_";
        std::vector<fs::path> copies;
        for (const fs::directory_entry &entry : fs::directory_iterator(path.parent_path(), ignored))
            if (entry.path().filename().string().starts_with(begin)) copies.push_back(entry.path());
        for (const fs::path &copy : copies) fs::remove(copy, ignored);
    }

    std::vector<std::string> faults() override
    {
        std::vector<std::string> found;
        for (const SqlRow &row : run("PRAGMA integrity_check").rows)
            if (text_of(row.at(0)) != "ok") found.push_back(text_of(row.at(0)));
        for (const SqlRow &row : run("PRAGMA foreign_key_check").rows)
            found.push_back("a row of the table '" + text_of(row.at(0)) + "' refers to a missing row of '" +
                            text_of(row.at(2)) + "'");
        return found;
    }

    std::string place() const override { return path_; }
    bool is_server() const override { return false; }

  private:
    std::string path_;
    sqlite3 *file_ = nullptr;

    // Creates the file with mode 0600, because SQLite would create it with the permissions of the umask.
    void create_private()
    {
        struct stat status;
        if (::stat(path_.c_str(), &status) == 0) {
            if (!S_ISREG(status.st_mode))
                throw RecordsError(Cause::refused, printable(path_) +
                                                       ": this is not a file; name the file of the "
                                                       "records by --records");
            return;
        }
        const int file = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
        if (file < 0) throw error_of_system(path_, errno);
        ::close(file);
    }

    // A SQLite file of another program is not changed. Only a file that this program has made is checked for
    // damage.
    void check_kind()
    {
        const bool is_new = whole_of(run("SELECT count(*) FROM sqlite_schema").rows.at(0).at(0)) == 0;
        if (!is_new && whole_of(run("PRAGMA application_id").rows.at(0).at(0)) != application_id)
            throw RecordsError(Cause::damaged, printable(path_) +
                                                   ": this SQLite file belongs to another program; "
                                                   "name another file by --records");
        const std::string verdict = text_of(run("PRAGMA quick_check(1)").rows.at(0).at(0));
        if (verdict != "ok") throw error_of(path_, SQLITE_CORRUPT, 0, verdict);
    }
};

} // namespace

std::unique_ptr<Database> open_sqlite(const std::string &path)
{
    return std::make_unique<SqliteDatabase>(path);
}

} // namespace crn
