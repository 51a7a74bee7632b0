// These tests check the following. Text of any length is formatted completely, and the special characters of
// HTML are escaped.
#include "host/base/format.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

void text_of_any_length_is_whole(void **)
{
    const std::string path(3000, 'p');
    assert_string_equal(formatted("%s: %.1f mm", path.c_str(), 2.25).c_str(), (path + ": 2.2 mm").c_str());
    assert_string_equal(formatted("%s", "").c_str(), "");
}

void a_line_ends(void **)
{
    assert_string_equal(formatted_line("%d of %d", 3, 4).c_str(), "3 of 4\n");
}

// Escaping makes the text safe in an element and in an attribute. Text that already contains escaped
// characters is escaped again.
void text_of_a_page_is_no_markup(void **)
{
    assert_string_equal(html_text("<b title=\"a\">R&D &amp;").c_str(),
                        "&lt;b title=&quot;a&quot;&gt;R&amp;D &amp;amp;");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(text_of_any_length_is_whole),
        cmocka_unit_test(a_line_ends),
        cmocka_unit_test(text_of_a_page_is_no_markup),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
