// Stores records on a PostgreSQL server, by the library libpqxx. This file is a separate library, because
// libpqxx loads sixteen more libraries that no other command needs; postgres_module.cpp opens it when the
// user names a server. A broken connection becomes RecordsError (unreachable). The caller may then open the
// database again and repeat the request safely, because the station has chosen the key of every row.
#include "host/base/number_text.hpp"
#include "host/base/terminal.hpp"
#include "host/records/database.hpp"
#include <cstdlib>
#include <optional>
#include <pqxx/pqxx>

namespace crn
{

namespace
{

using Cause = RecordsError::Cause;

// Gives the numbers by which PostgreSQL names the types of result columns (pg_type.dat).
enum : pqxx::oid {
    type_bool = 16,
    type_int8 = 20,
    type_int2 = 21,
    type_int4 = 23,
    type_float4 = 700,
    type_float8 = 701
};

// Removes the password from a URL, so that no message shows the password.
std::string without_password(const std::string &url)
{
    const std::size_t begin = url.find("://"), at = url.find('@'), slash = url.find('/', begin + 3);
    if (begin == url.npos || at == url.npos || (slash != url.npos && slash < at)) return printable(url);
    const std::size_t colon = url.find(':', begin + 3);
    if (colon == url.npos || colon > at) return printable(url);
    return printable(url.substr(0, colon) + url.substr(at));
}

std::string one_line(std::string text)
{
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    for (char &letter : text)
        if (letter == '\n' || letter == '\t') letter = ' ';
    return printable(text);
}

SqlValue value_of(const pqxx::field &field)
{
    if (field.is_null()) return {};
    switch (field.type()) {
    case type_int2:
    case type_int4:
    case type_int8:
        return std::int64_t{std::strtoll(field.c_str(), nullptr, 10)};
    case type_bool:
        return std::int64_t{field.c_str()[0] == 't'};
    case type_float4:
    case type_float8: {
        double number = 0.0;
        field.to(number); // libpqxx reads numbers in the locale "C"
        return number;
    }
    default:
        return std::string(field.c_str(), field.size());
    }
}

std::optional<std::string> parameter_of(const SqlValue &value)
{
    if (const auto *whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
    if (const auto *number = std::get_if<double>(&value)) return number_text(*number, 17);
    if (const auto *text = std::get_if<std::string>(&value)) return *text;
    return std::nullopt;
}

class PostgresDatabase : public Database
{
  public:
    explicit PostgresDatabase(const std::string &url) : place_(without_password(url))
    {
        guarded([&] { connection_ = std::make_unique<pqxx::connection>(url); });
        guarded([&] { connection_->set_variable("synchronous_commit", "on"); });
    }

    SqlResult run(const std::string &statement, const std::vector<SqlValue> &values) override
    {
        SqlResult result;
        std::vector<std::optional<std::string>> texts;
        for (const SqlValue &value : values) texts.push_back(parameter_of(value));
        std::vector<const char *> parameters;
        for (const auto &text : texts) parameters.push_back(text ? text->c_str() : nullptr);
        guarded([&] {
            if (work_) {
                take(result, work_->exec_params(statement, pqxx::prepare::make_dynamic_params(parameters)));
            } else {
                pqxx::nontransaction work(*connection_);
                take(result, work.exec_params(statement, pqxx::prepare::make_dynamic_params(parameters)));
            }
        });
        return result;
    }

    void run_all(const std::string &statements) override
    {
        guarded([&] {
            if (work_) {
                work_->exec(statements);
            } else {
                pqxx::nontransaction work(*connection_);
                work.exec(statements);
            }
        });
    }

    void begin() override
    {
        guarded([&] { work_ = std::make_unique<pqxx::work>(*connection_); });
    }
    void commit() override
    {
        guarded([&] { work_->commit(); });
        work_.reset();
    }
    void roll_back() noexcept override { work_.reset(); } // its destructor aborts

    int version() override
    {
        if (is_null(run("SELECT to_regclass('cournand_version')::text", {}).rows.at(0).at(0))) return 0;
        const SqlResult found = run("SELECT version FROM cournand_version", {});
        return found.rows.empty() ? 0 : static_cast<int>(whole_of(found.rows.at(0).at(0)));
    }
    void set_version(int version) override
    {
        run_all("CREATE TABLE IF NOT EXISTS cournand_version (version BIGINT NOT NULL)");
        run_all("DELETE FROM cournand_version");
        run("INSERT INTO cournand_version VALUES ($1)", {std::int64_t{version}});
    }
    void lock(const std::string &name) override
    {
        run("SELECT pg_advisory_xact_lock(hashtext($1))", {"cournand " + name});
    }
    std::string back_up(const std::string &) override { return ""; }
    void forget_deleted() override { run_all("VACUUM"); }
    std::vector<std::string> faults() override { return {}; }
    std::string place() const override { return place_; }
    bool is_server() const override { return true; }

  private:
    std::string place_;
    std::unique_ptr<pqxx::connection> connection_;
    std::unique_ptr<pqxx::work> work_;

    static void take(SqlResult &result, const pqxx::result &rows)
    {
        for (const pqxx::row &row : rows) {
            SqlRow values;
            for (const pqxx::field &field : row) values.push_back(value_of(field));
            result.rows.push_back(std::move(values));
        }
        result.changed = static_cast<std::int64_t>(rows.affected_rows());
    }

    // A server that is starting or shutting down reports errors of the SQLSTATE classes 57P and 08. If no
    // answer to a commit arrives, the result of the commit is unknown. The same request may be repeated after
    // errors of the SQLSTATE classes 57P and 08, and after a commit without an answer.
    template <typename Action> void guarded(Action action)
    {
        try {
            action();
        } catch (const pqxx::broken_connection &error) {
            throw unreachable(error.what());
        } catch (const pqxx::in_doubt_error &error) {
            throw unreachable(error.what());
        } catch (const pqxx::sql_error &error) {
            const std::string &state = error.sqlstate();
            if (state.empty() || state.starts_with("57P") || state.starts_with("08") ||
                state.starts_with("40"))
                throw unreachable(error.what());
            if (state.starts_with("53"))
                throw RecordsError(Cause::no_space,
                                   place_ + ": the server has no room: " + one_line(error.what()));
            throw RecordsError(Cause::refused, place_ + ": " + one_line(error.what()));
        } catch (const pqxx::failure &error) {
            throw unreachable(error.what());
        }
    }

    RecordsError unreachable(const std::string &reason) const
    {
        return {Cause::unreachable,
                place_ + ": the server cannot be reached: " + one_line(reason) +
                    ". Sessions stay in the station's own file; `cournand records ship` sends "
                    "them later"};
    }
};

} // namespace

} // namespace crn

extern "C" __attribute__((visibility("default"))) crn::Database *crn_open_postgres(const char *url)
{
    return new crn::PostgresDatabase(url);
}
