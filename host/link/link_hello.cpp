// The first word of a conversation, said again while another program still leads the rig.
#include "host/link/link.hpp"

namespace crn
{

crn_wire_hello_reply Link::hello()
{
    constexpr int patience = 10; // a program that is gone is forgotten 42 ms after its last word
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
