// Gives SQLite and PostgreSQL one interface, so that the SQL statements of host/records are the same for both
// databases.
#pragma once
#include "host/records/record.hpp"
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace crn
{

using SqlValue = std::variant<std::monostate, std::int64_t, double, std::string>;
using SqlRow = std::vector<SqlValue>;
struct SqlResult {
    std::vector<SqlRow> rows;
    std::int64_t changed = 0; // rows that the statement inserted, updated or deleted itself
};

// The following functions return the value of a column; for null they return 0, 0.0 or an empty text.
inline std::int64_t whole_of(const SqlValue &value)
{
    if (const auto *whole = std::get_if<std::int64_t>(&value)) return *whole;
    if (const auto *number = std::get_if<double>(&value)) return static_cast<std::int64_t>(*number);
    return 0;
}

inline double number_of(const SqlValue &value)
{
    if (const auto *whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto *number = std::get_if<double>(&value)) return *number;
    return 0.0;
}

inline std::string text_of(const SqlValue &value)
{
    const auto *text = std::get_if<std::string>(&value);
    return text ? *text : std::string();
}

inline bool is_null(const SqlValue &value)
{
    return std::holds_alternative<std::monostate>(value);
}

class Database
{
  public:
    virtual ~Database() = default;
    // Runs one statement with its parameters. Throws RecordsError.
    virtual SqlResult run(const std::string &statement, const std::vector<SqlValue> &values = {}) = 0;
    // Runs several statements without parameters, separated by semicolons. Throws RecordsError.
    virtual void run_all(const std::string &statements) = 0;
    virtual void begin() = 0;
    virtual void commit() = 0;
    virtual void roll_back() noexcept = 0;

    // Returns the version of the database's schema; 0 means that the database has no records yet.
    virtual int version() = 0;
    virtual void set_version(int version) = 0;
    // Within a transaction, this function waits until no other program holds the lock of this name, and then
    // holds it until the transaction ends. The names of locks are "schema" and the ids of trainees.
    virtual void lock(const std::string &name) = 0;
    // Copies the database before a migration and returns the name of the copy; for a server, which makes its
    // own backups, it returns an empty text.
    virtual std::string back_up(const std::string &reason) = 0;
    // Overwrites the bytes of deleted rows, after a person's data was erased.
    virtual void forget_deleted() = 0;
    // Returns one line for each fault that the database check finds; the list is empty if the database is
    // sound.
    virtual std::vector<std::string> faults() = 0;

    virtual std::string place() const = 0; // for messages: a path, or a URL without its password
    virtual bool is_server() const = 0;
};

// Holds a database transaction, which is rolled back unless it is committed.
class Transaction
{
  public:
    explicit Transaction(Database &database) : database_(database) { database_.begin(); }
    ~Transaction()
    {
        if (!is_done_) database_.roll_back();
    }
    Transaction(const Transaction &) = delete;
    Transaction &operator=(const Transaction &) = delete;
    void commit()
    {
        database_.commit();
        is_done_ = true;
    }

  private:
    Database &database_;
    bool is_done_ = false;
};

// Opens the SQLite file, or creates it with mode 0600 (only the owner may read and write). Throws
// RecordsError if the file is damaged, or is not a file of records.
std::unique_ptr<Database> open_sqlite(const std::string &path);
// `url` is a URL of libpq, postgresql://USER@HOST:PORT/DATABASE?OPTION=VALUE. Throws RecordsError.
std::unique_ptr<Database> open_postgres(const std::string &url);

// Brings the database to the newest version of the schema, with one transaction per migration, after it has
// copied the database. Throws RecordsError (newer) if the database is from a newer program.
void migrate(Database &database);
// For tests, applies the given migrations instead of the program's; entry i leads from version i to i + 1.
void migrate(Database &database, const std::vector<std::string> &migrations);

} // namespace crn
