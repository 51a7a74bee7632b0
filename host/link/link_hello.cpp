// Sends HELLO, the first message of a conversation, and repeats it while the device refuses because another
// program still controls the rig.
#include "host/link/link.hpp"

namespace crn
{

crn_wire_hello_reply Link::hello()
{
    constexpr int patience = 10; // the device forgets a program that has gone 42 ms after its last message
    for (int attempt = 1;; attempt++) {
        try {
            return hello_once();
        } catch (const LinkError &error) {
            if (error.reject.code != CRN_REJECT_BUSY || attempt == patience) throw;
        }
        transport_.pass_time_ms(10);
    }
}

} // namespace crn
