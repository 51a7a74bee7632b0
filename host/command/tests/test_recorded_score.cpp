// Tests the score of a recording in which tools were exchanged. The report must name the tools that are in
// the vessels at the end, as the session's own report does.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <unistd.h>
#include <vector>

#include "host/base/examples.hpp"
#include "host/command/recorded_score.hpp"
#include "host/session/run.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

void the_report_names_the_tools_on_the_line(void **)
{
    const std::string path = "/tmp/cournand_test_score_" + std::to_string(getpid()) + ".rec";
    const std::vector<std::string> names = {"j_wire", "coronary_014"};
    std::vector<crn::Instrument> table;
    for (const std::string &name : names)
        table.push_back(crn::read_instrument(crn::example_path(crn::instrument_files, name)));
    crn::Session session =
        crn::parse_session("begin with j_wire\nbegin inserted 20 mm\n"
                           "withdraw wire 20 mm at 100 mm/s\nexchange wire for coronary_014\nwait 100 ms",
                           "a.session");
    const crn::LineNumbers line = crn::resolve_tools(session, names);
    const crn::SceneFile scene = crn::read_scene("");
    crn::Device device(scene, table, crn::entry_of(scene, line.size(), session.inserted_um), crn::host_rig(),
                       {}, line);
    crn::PatientSettings settings;
    settings.line = line;
    crn::Patient patient({}, table, settings);
    {
        crn::Recorder recorder(path, device.recording_header("a.session"));
        const crn::RunResult result = crn::run_session(device, patient, session, &recorder, nullptr, {});
        if (!result.failures.empty()) fail_msg("%s", result.failures[0].c_str());
    }
    const crn::RecordedScore score = crn::score_recording({path, "", "", {}, nullptr, {}});
    std::remove(path.c_str());
    assert_int_equal(score.report["tools"].size(), 1);
    assert_string_equal(score.report["tools"][0]["name"].get<std::string>().c_str(), table[1].name.c_str());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(the_report_names_the_tools_on_the_line)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
