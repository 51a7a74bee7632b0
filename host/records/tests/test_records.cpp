// Tests the records of trainees in a file: stored data can be read back, invalid data is refused with a
// remedy, files of other versions or programs stay unchanged, and no erased bytes remain in the file.
#include "host/base/tests/folder.hpp"
#include "host/base/text.hpp"
#include "host/records/exchange.hpp"
#include "host/records/outbox.hpp"
#include "host/records/schema.hpp"
#include "host/records/tests/sample_records.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn;
using Cause = RecordsError::Cause;

// Returns the message of the RecordsError that `action` must throw; the error must have this cause.
std::string refusal(Cause cause, const std::function<void()> &action)
{
    try {
        action();
    } catch (const RecordsError &error) {
        assert_int_equal(static_cast<int>(error.cause), static_cast<int>(cause));
        return error.what();
    }
    fail_msg("nothing was refused");
    return "";
}

void assert_says(const std::string &text, const std::string &words)
{
    if (text.find(words) == text.npos) fail_msg("'%s' does not say '%s'", text.c_str(), words.c_str());
}

bool has_bytes(const std::filesystem::path &folder, const std::string &bytes)
{
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        const std::vector<unsigned char> content = read_binary_file(entry.path().string());
        if (std::string(content.begin(), content.end()).find(bytes) != std::string::npos) return true;
    }
    return false;
}

// These test vectors come from FIPS 180-4 (NIST CSRC examples) and RFC 9562, A.4.
void hashes_and_names_agree_with_published_examples(void **)
{
    assert_string_equal(sha256("abc").c_str(),
                        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_string_equal(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").c_str(),
                        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    assert_string_equal(sha256("").c_str(),
                        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    assert_string_equal(uuid_v5("6ba7b810-9dad-11d1-80b4-00c04fd430c8", "www.example.com").c_str(),
                        "2ed6657d-e927-568b-95e1-2665a8aea6a2");
    const std::string first = new_uuid(), second = new_uuid();
    assert_true(is_uuid(first) && first[14] == '7' && first != second);
    assert_false(is_uuid("2ED6657D-e927-568b-95e1-2665a8aea6a2"));
}

void moments_and_dates_of_the_calendar_are_accepted(void **)
{
    assert_true(unix_ms_of("1970-01-01T00:00:01.500Z") == std::optional<std::int64_t>(1500));
    assert_string_equal(utc_text(*unix_ms_of("2028-02-29T23:59:59.999Z")).c_str(),
                        "2028-02-29T23:59:59.999Z");
    for (const char *wrong :
         {"2027-02-29T00:00:00.000Z", "2027-01-01 00:00:00.000Z", "2027-01-01T24:00:00.000Z", ""})
        assert_false(unix_ms_of(wrong).has_value());
    assert_true(is_date("2027-12-31"));
    assert_false(is_date("2027-13-01"));
}

void a_stored_session_is_read_back_whole(void **)
{
    const tests::Folder folder("records");
    const SessionRecord record = sample_record("otter", 1);
    {
        RecordStore store = open_store(folder.file("records.db"));
        assert_string_equal(store.save(record).c_str(), record.id.c_str());
    }
    RecordStore store = open_store(folder.file("records.db"));
    SessionRecord wanted = record;
    wanted.station = store.own_station().id;
    const SessionRecord found = store.session(record.id.substr(0, 13));
    assert_string_equal(json_of(found).dump().c_str(), json_of(wanted).dump().c_str());
    assert_true(found.seed == record.seed); // 64 bits without a sign
    assert_float_equal(*found.metric("errors"), 3.0, 0.0);
    assert_float_equal(*found.metric("score"), 70.0, 1e-12);
}

// A session without pass, score, metrics and events is complete as well.
void a_session_may_have_neither_score_nor_metrics(void **)
{
    const tests::Folder folder("records");
    RecordStore store = open_store(folder.file("records.db"));
    SessionRecord record;
    record.trainee = "otter";
    record.case_id = "first_push";
    record.started_at = utc_now();
    const SessionRecord found = store.session(store.save(record));
    assert_true(!found.score && !found.passed && found.metrics.empty() && found.events.empty());
    assert_int_equal(found.id[14], '7'); // made by the store
}

void a_session_that_is_stored_twice_is_there_once(void **)
{
    const tests::Folder folder("records");
    RecordStore store = open_store(folder.file("records.db"));
    for (int i = 0; i < 3; i++) store.save(sample_record("otter", 1));
    assert_int_equal(store.sessions({}).size(), 1);
    assert_int_equal(store.sessions({})[0].events.size(), 4);
}

void two_open_files_do_not_disturb_each_other(void **)
{
    const tests::Folder folder("records");
    RecordStore one = open_store(folder.file("records.db")), other = open_store(folder.file("records.db"));
    for (int i = 0; i < 10; i++) {
        one.save(sample_record("otter", i));
        other.save(sample_record("heron", i));
        assert_int_equal(one.sessions({}, false).size(), 2 * i + 2);
    }
}

void only_the_user_may_read_the_file(void **)
{
    const tests::Folder folder("records");
    open_store(folder.file("records.db")).save(sample_record("otter", 1));
    struct stat status;
    assert_int_equal(::stat(folder.file("records.db").c_str(), &status), 0);
    assert_int_equal(status.st_mode & 0777, 0600);
}

// Texts that a server could not store later (control characters, other encodings) are refused at once.
void a_record_outside_its_ranges_is_refused(void **)
{
    const tests::Folder folder("records");
    RecordStore store = open_store(folder.file("records.db"));
    const auto refused = [&](const std::function<void(SessionRecord &)> &change, const char *words) {
        SessionRecord record = sample_record("otter", 1);
        change(record);
        assert_says(refusal(Cause::refused, [&] { store.save(record); }), words);
    };
    refused([](SessionRecord &record) { record.trainee = ""; }, "pseudonym is empty");
    refused([](SessionRecord &record) { record.trainee = "a\nb"; }, "control characters");
    refused([](SessionRecord &record) { record.trainee = std::string("a\0b", 3); }, "control characters");
    refused([](SessionRecord &record) { record.case_id = "\xff"; }, "not UTF-8");
    refused([](SessionRecord &record) { record.started_at = "yesterday"; }, "2026-11-24T20:14:57.123Z");
    refused([](SessionRecord &record) { record.metrics[1].value = std::numeric_limits<double>::quiet_NaN(); },
            "'kap_Gy_cm2' is not a finite number");
    refused([](SessionRecord &record) { record.metrics[1].name = "contrast_ml"; }, "two metrics");
    refused([](SessionRecord &record) { record.events[0].severity = 6; }, "severity 6");
    refused([](SessionRecord &record) { record.score->of = 0.0; }, "not above 0");
    refused([](SessionRecord &record) { record.id = "17"; }, "not a UUID");
    assert_int_equal(store.sessions({}).size(), 0);
}

void a_mistyped_trainee_is_corrected(void **)
{
    const tests::Folder folder("records");
    RecordStore store = open_store(folder.file("records.db"));
    store.save(sample_record("otter", 1));
    assert_says(refusal(Cause::refused, [&] { store.trainee("oter"); }), "did you mean 'otter'?");
}

// --- versions and strange files ---

const char *const later = "CREATE TABLE remark (session_id TEXT PRIMARY KEY, words TEXT NOT NULL)";

void a_newer_file_is_refused_and_left_as_it_is(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    open_store(path).save(sample_record("otter", 1));
    auto database = open_sqlite(path);
    database->set_version(99);
    database.reset();
    const std::vector<unsigned char> before = read_binary_file(path);
    const std::string text = refusal(Cause::newer, [&] { open_store(path); });
    assert_says(text, path);
    assert_says(text, "update Cournand");
    assert_true(read_binary_file(path) == before);
}

void a_migration_keeps_the_data_and_a_copy_of_the_old_file(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    open_store(path).save(sample_record("otter", 1));
    auto database = open_sqlite(path);
    std::vector<std::string> migrations = schema_migrations();
    migrations.push_back(later);
    migrate(*database, migrations);
    assert_int_equal(database->version(), migrations.size());
    assert_int_equal(database->run("SELECT * FROM session").rows.size(), 1);
    assert_int_equal(database->run("SELECT * FROM remark").rows.size(), 0);
    int copies = 0;
    for (const auto &entry : std::filesystem::directory_iterator(folder.path))
        if (entry.path().filename().string().starts_with("records.db.before_version_")) {
            copies++;
            RecordStore copy = open_store(entry.path().string()); // a whole file of the old version
            assert_int_equal(copy.sessions({}).size(), 1);
        }
    assert_int_equal(copies, 1);
}

void a_migration_that_fails_changes_nothing(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    open_store(path).save(sample_record("otter", 1));
    auto database = open_sqlite(path);
    std::vector<std::string> migrations = schema_migrations();
    migrations.push_back(
        "CREATE TABLE remark (words TEXT); CREATE TABLE session (id TEXT)"); // the second exists
    refusal(Cause::refused, [&] { migrate(*database, migrations); });
    assert_int_equal(database->version(), schema_migrations().size());
    assert_int_equal(database->run("SELECT * FROM sqlite_schema WHERE name = 'remark'").rows.size(), 0);
}

void a_damaged_or_foreign_file_is_refused_with_its_path_and_a_remedy(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    std::ofstream(path) << std::string(5000, 'x');
    std::string text = refusal(Cause::damaged, [&] { open_store(path); });
    assert_says(text, path);
    assert_says(text, "Put a backup in its place");

    const std::string other = folder.file("other.db");
    open_sqlite(other)->run_all("CREATE TABLE recipes (name TEXT)");
    assert_says(refusal(Cause::damaged, [&] { open_store(other); }), "belongs to another program");

    const std::string holed = folder.file("holed.db");
    {
        RecordStore store = open_store(holed);
        for (int i = 0; i < 50; i++) store.save(sample_record("otter", i));
    }
    std::fstream file(holed, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(3 * 4096);
    file << std::string(4096, '\x5a');
    file.close();
    assert_says(refusal(Cause::damaged, [&] { open_store(holed); }), holed);

    assert_says(refusal(Cause::refused, [&] { open_store(folder.path); }), "--records");
    assert_says(refusal(Cause::refused, [&] { open_store(folder.file("no/records.db")); }), "No such file");
    assert_says(refusal(Cause::refused, [&] { open_store("mysql://host/x"); }), "postgresql://");
}

// --- erasing ---

void erased_data_is_gone_from_every_byte_of_the_folder(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    {
        RecordStore store = open_store(path);
        for (int i = 0; i < 30; i++) store.save(sample_record("zebrafinch", i));
        store.save(sample_record("otter", 1));
        store.set_name("zebrafinch", "Wilhelmina Quicksilver");
        auto database = open_sqlite(path);
        std::vector<std::string> migrations = schema_migrations();
        migrations.push_back(later);
        migrate(*database, migrations); // leaves a copy, which has the data too
        database->run_all("DROP TABLE remark");
        database->set_version(static_cast<int>(schema_migrations().size()));
        assert_true(has_bytes(folder.path, "zebrafinch") && has_bytes(folder.path, "Quicksilver"));
        assert_int_equal(store.erase("zebrafinch"), 30);
        assert_false(has_bytes(folder.path, "zebrafinch") || has_bytes(folder.path, "Quicksilver"));
    }
    RecordStore store = open_store(path);
    assert_int_equal(store.sessions({}).size(), 1);
    assert_int_equal(store.faults().size(), 0);
    const SqlResult events = store.database().run("SELECT count(*) FROM event");
    assert_int_equal(whole_of(events.rows[0][0]), 4); // those of the other trainee
    assert_says(refusal(Cause::refused, [&] { store.save(sample_record("zebrafinch", 1)); }),
                "data was erased");
}

void a_deleted_name_and_an_old_pseudonym_are_gone_too(void **)
{
    const tests::Folder folder("records");
    RecordStore store = open_store(folder.file("records.db"));
    store.save(sample_record("zebrafinch", 1));
    store.set_name("zebrafinch", "Wilhelmina Quicksilver");
    assert_string_equal(store.name("zebrafinch").c_str(), "Wilhelmina Quicksilver");
    store.set_name("zebrafinch", "");
    store.rename("zebrafinch", "otter");
    assert_false(has_bytes(folder.path, "zebrafinch") || has_bytes(folder.path, "Quicksilver"));
    assert_int_equal(store.sessions({"otter", "", ""}).size(), 1);
    // The trainee's id follows from the first pseudonym, so nobody else may get this pseudonym later.
    assert_says(refusal(Cause::refused, [&] { store.add_trainee("zebrafinch"); }), "another one today");
}

void trainees_past_their_date_are_found(void **)
{
    const tests::Folder folder("records");
    RecordStore store = open_store(folder.file("records.db"));
    Trainee trainee = store.add_trainee("otter");
    trainee.keep_until = "2027-12-31";
    store.change(trainee);
    store.add_trainee("heron");
    assert_int_equal(store.expired("2027-12-31").size(), 0);
    assert_int_equal(store.expired("2028-01-01").size(), 1);
    trainee.keep_until = "31.12.2027";
    assert_says(refusal(Cause::refused, [&] { store.change(trainee); }), "2027-12-31");
}

// --- exchange ---

void exported_sessions_are_imported_unchanged(void **)
{
    const tests::Folder folder("records");
    std::vector<SessionRecord> records{sample_record("otter", 1), sample_record("heron \"x\", =1", 2)};
    for (SessionRecord &record : records) record.station = uuid_of_name("station", "a");
    const std::string text = json_of(records).dump();
    const std::vector<SessionRecord> read = records_of_json(text, "x.json");
    assert_string_equal(json_of(read).dump().c_str(), text.c_str());
    assert_says(refusal(Cause::refused, [] { records_of_json("{}", "x.json"); }), "x.json");
    std::string wrong = text;
    wrong.replace(wrong.find("\"severity\":3"), 12, "\"severity\":9");
    assert_says(refusal(Cause::refused, [&] { records_of_json(wrong, "x.json"); }), "session 1: ");
}

void a_spreadsheet_takes_no_text_for_a_formula(void **)
{
    SessionRecord record = sample_record("=cmd|x", 1);
    record.case_id = "a,\"b\"";
    const std::string csv = csv_of({record});
    assert_says(csv, ",'=cmd|x,");
    assert_says(csv, ",\"a,\"\"b\"\"\",");
    assert_says(csv, "metric fluoroscopy_min,metric kap_Gy_cm2");
    assert_says(csv, ",70,100,3,"); // score, of, errors
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(hashes_and_names_agree_with_published_examples),
        cmocka_unit_test(moments_and_dates_of_the_calendar_are_accepted),
        cmocka_unit_test(a_stored_session_is_read_back_whole),
        cmocka_unit_test(a_session_may_have_neither_score_nor_metrics),
        cmocka_unit_test(a_session_that_is_stored_twice_is_there_once),
        cmocka_unit_test(two_open_files_do_not_disturb_each_other),
        cmocka_unit_test(only_the_user_may_read_the_file),
        cmocka_unit_test(a_record_outside_its_ranges_is_refused),
        cmocka_unit_test(a_mistyped_trainee_is_corrected),
        cmocka_unit_test(a_newer_file_is_refused_and_left_as_it_is),
        cmocka_unit_test(a_migration_keeps_the_data_and_a_copy_of_the_old_file),
        cmocka_unit_test(a_migration_that_fails_changes_nothing),
        cmocka_unit_test(a_damaged_or_foreign_file_is_refused_with_its_path_and_a_remedy),
        cmocka_unit_test(erased_data_is_gone_from_every_byte_of_the_folder),
        cmocka_unit_test(a_deleted_name_and_an_old_pseudonym_are_gone_too),
        cmocka_unit_test(trainees_past_their_date_are_found),
        cmocka_unit_test(exported_sessions_are_imported_unchanged),
        cmocka_unit_test(a_spreadsheet_takes_no_text_for_a_formula),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
