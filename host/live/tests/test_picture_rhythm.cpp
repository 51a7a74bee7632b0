// The GUI window must wait for a picture only if drawing a screen now would delay that picture.
#include <chrono>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

#include "host/live/picture_rhythm.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::PictureRhythm;
using std::chrono::milliseconds;

PictureRhythm::Time at_ms(int ms)
{
    return PictureRhythm::Time(std::chrono::seconds(1000) + milliseconds(ms));
}

// The test has pictures at 0 and 33 ms, so the next picture is due at 66 ms.
PictureRhythm thirty_per_second()
{
    PictureRhythm rhythm;
    rhythm.picture_came(at_ms(0));
    rhythm.picture_came(at_ms(33));
    return rhythm;
}

void a_screen_that_ends_before_the_picture_is_drawn(void **)
{
    assert_false(thirty_per_second().is_picture_near(at_ms(50), milliseconds(15)));
}

void a_screen_that_would_delay_the_picture_waits(void **)
{
    assert_true(thirty_per_second().is_picture_near(at_ms(52), milliseconds(15)));
}

void a_picture_that_does_not_come_is_not_waited_for(void **)
{
    assert_true(thirty_per_second().is_picture_near(at_ms(73), milliseconds(15)));
    assert_false(thirty_per_second().is_picture_near(at_ms(75), milliseconds(15)));
}

void single_pictures_have_no_rhythm(void **)
{
    PictureRhythm rhythm;
    assert_false(rhythm.is_picture_near(at_ms(10), milliseconds(15)));
    rhythm.picture_came(at_ms(0));
    assert_false(rhythm.is_picture_near(at_ms(60), milliseconds(15)));
    rhythm.picture_came(at_ms(500));
    assert_false(rhythm.is_picture_near(at_ms(990), milliseconds(15)));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_screen_that_ends_before_the_picture_is_drawn),
        cmocka_unit_test(a_screen_that_would_delay_the_picture_waits),
        cmocka_unit_test(a_picture_that_does_not_come_is_not_waited_for),
        cmocka_unit_test(single_pictures_have_no_rhythm),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
