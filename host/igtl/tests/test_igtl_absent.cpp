// Tests the program that is built without libOpenIGTLink: it refuses the option --igtl, and names the remedy.
#include "host/base/output_files.hpp"
#include "host/igtl/server.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstring>
extern "C" {
#include <cmocka.h>
}

namespace
{

void a_program_without_openigtlink_names_the_command_that_builds_it(void **)
{
    try {
        crn::open_igtl({});
        fail_msg("a server was opened");
    } catch (const crn::UsageError &error) {
        assert_non_null(std::strstr(error.what(), "--igtl: this program was built without OpenIGTLink"));
        assert_non_null(std::strstr(error.what(), "make igtl"));
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_program_without_openigtlink_names_the_command_that_builds_it)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
