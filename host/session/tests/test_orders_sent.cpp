// A device that has just stopped by a fault takes no orders. In FREE_RUN the host learns of the fault with
// its next request, and must report the fault and not the refused order.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

#include "host/link/sim_transport.hpp"
#include "host/session/run.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

crn_wire_order_list faster_heart()
{
    return {1, {crn_wire_order_of_rhythm({CRN_WIRE_RHYTHM_HEART_RATE, 80})}};
}

void a_device_that_no_longer_runs_is_no_error_of_the_order(void **)
{
    crn::SimTransport pipe(0);
    crn::Link link(pipe);
    link.hello();
    link.use_free_run();
    crn::send_orders(link, faster_heart());
    assert_int_equal(link.read_status().state, CRN_WIRE_STATE_READY);
}

void every_other_refusal_is_an_error(void **)
{
    crn::SimTransport pipe(0);
    crn::Link link(pipe);
    link.hello(); // in LOCKSTEP, orders come with the ticks
    std::uint16_t code = 0;
    try {
        crn::send_orders(link, faster_heart());
    } catch (const crn::LinkError &error) {
        code = error.reject.code;
    }
    assert_int_equal(code, CRN_REJECT_WRONG_MODE);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_device_that_no_longer_runs_is_no_error_of_the_order),
        cmocka_unit_test(every_other_refusal_is_an_error),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
