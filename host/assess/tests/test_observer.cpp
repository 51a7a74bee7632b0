// Tests that the observer of an assessment follows which tools are on the line (nested in the vessels). A
// session may have more tools than can be nested in each other; every recorded moment has one entry for each
// position on the line (the nested tools).
#include "host/assess/observer.hpp"
#include "host/session/run.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

// In the session's table of tools, the order of the tools differs from that in the vessels.
const std::vector<std::string> &names()
{
    static const std::vector<std::string> list = {"balloon_3x20", "guide_jl4_6f", "terumo_4f", "coronary_014",
                                                  "amplatz_super_stiff"};
    return list;
}

const std::vector<crn::Instrument> &table()
{
    static const std::vector<crn::Instrument> tools = [] {
        std::vector<crn::Instrument> read;
        for (const std::string &name : names())
            read.push_back(crn::read_instrument("shared/examples/instruments/" + name + ".toml"));
        return read;
    }();
    return tools;
}

const crn::SessionLog &observed()
{
    static const crn::SessionLog log = [] {
        crn::Session session = crn::parse_session("begin with amplatz_super_stiff nothing guide_jl4_6f\n"
                                                  "begin wire inserted 60 mm\nbegin guide inserted 50 mm\n"
                                                  "withdraw wire until inserted 0 mm at 100 mm/s\n"
                                                  "exchange wire for coronary_014\n"
                                                  "advance wire until inserted 70 mm at 40 mm/s\n"
                                                  "load balloon_3x20 as catheter\nwait 100 ms",
                                                  "a.session");
        const crn::SceneFile scene = crn::read_scene("");
        crn::PatientSettings settings;
        settings.line = crn::resolve_tools(session, names());
        const crn_wire_entry entry = crn::entry_of(scene, settings.line.size(), session.inserted_um);
        crn::Device device(scene, table(), entry, crn::host_rig(), {}, settings.line);
        crn::Patient patient({}, table(), settings);
        const crn::TipPlaces tips({}, {});
        crn::AssessObserver observer(patient, table(), tips);
        const crn::RunResult result = crn::run_session(device, patient, session, nullptr, &observer, {});
        for (const std::string &failure : result.failures) fail_msg("%s", failure.c_str());
        return observer.log();
    }();
    return log;
}

void every_position_has_the_names_of_its_tools(void **)
{
    const std::vector<std::string> &tools = observed().tools;
    assert_int_equal(tools.size(), 3);
    assert_string_equal(tools[0].c_str(), (table()[4].name + ", then " + table()[3].name).c_str());
    assert_string_equal(tools[1].c_str(), table()[0].name.c_str());
    assert_string_equal(tools[2].c_str(), table()[1].name.c_str());
}

void every_moment_has_the_length_of_the_tool_at_its_position(void **)
{
    const crn::SessionMoment &last = observed().moments.back();
    assert_true(last.tools[0].inserted_mm > 69.0 && last.tools[0].inserted_mm < 78.0);
    assert_true(last.tools[1].inserted_mm < 1.0); // the balloon is in the sheath
    assert_true(last.tools[2].inserted_mm > 45.0 && last.tools[2].inserted_mm < 55.0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_position_has_the_names_of_its_tools),
        cmocka_unit_test(every_moment_has_the_length_of_the_tool_at_its_position),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
