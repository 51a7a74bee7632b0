// Tests the model of a person's hands: the same seed gives the same session, novices make more and shorter
// motions than experts, and every push ends at the script's length.
#include "host/script/hand_model.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
extern "C" {
#include <cmocka.h>
}

namespace
{

const char *const script = "begin inserted 20 mm\n"
                           "table y 50 mm\n"
                           "fluoro on\n"
                           "advance until inserted 200 mm at 40 mm/s\n"
                           "rotate 90 deg\n"
                           "fluoro off\n"
                           "cine on\n"
                           "wait 1 s\n"
                           "cine off\n"
                           "inflate to 8 bar\n"
                           "expect inserted at least 100 mm\n";

crn::Session played(const std::string &hands)
{
    return crn::with_hands(crn::parse_session(script, "a.session"), crn::read_hands(hands));
}

std::size_t motions(const crn::Session &session)
{
    std::size_t count = 0;
    for (const crn::Statement &statement : session.statements) count += !statement.moves.empty();
    return count;
}

bool is_equal(const crn::Session &a, const crn::Session &b)
{
    if (a.statements.size() != b.statements.size()) return false;
    for (std::size_t i = 0; i < a.statements.size(); ++i) {
        const crn::Statement &one = a.statements[i], &other = b.statements[i];
        if (one.wait_ticks != other.wait_ticks || one.room != other.room ||
            one.moves.size() != other.moves.size())
            return false;
        for (std::size_t k = 0; k < one.moves.size(); ++k)
            if (one.moves[k].distance_counts != other.moves[k].distance_counts ||
                one.moves[k].speed_counts_per_s != other.moves[k].speed_counts_per_s)
                return false;
    }
    return true;
}

void the_same_seed_gives_the_same_session(void **)
{
    assert_true(is_equal(played("novice:5"), played("novice:5")));
    assert_false(is_equal(played("novice:5"), played("novice:6")));
    assert_false(is_equal(played("novice:5"), played("expert:5")));
}

void novices_make_more_motions_than_experts(void **)
{
    std::size_t experts = 0, novices = 0;
    for (int seed = 1; seed <= 20; ++seed) {
        experts += motions(played("expert:" + std::to_string(seed)));
        novices += motions(played("novice:" + std::to_string(seed)));
    }
    assert_true(novices > 2 * experts);
}

void every_push_ends_where_the_script_wants_it(void **)
{
    for (const char *skill : {"expert:", "novice:", "clumsy:"})
        for (int seed = 1; seed <= 20; ++seed) {
            std::int64_t inserted_um = 20000;
            for (const crn::Statement &statement : played(skill + std::to_string(seed)).statements)
                for (const crn::HandMove &move : statement.moves)
                    if (move.axis == crn::HandAxis::translation)
                        inserted_um = move.until_inserted_um.value_or(inserted_um + move.distance_counts);
            assert_int_equal(inserted_um, 200000);
        }
}

// A pedal that the hand model presses late is still pressed, and a pedal that the foot has left is pressed
// again.
void the_pedals_end_as_in_the_script(void **)
{
    for (int seed = 1; seed <= 50; ++seed) {
        int fluoro = 0, cine = 0, presses = 0;
        for (const crn::Statement &statement : played("clumsy:" + std::to_string(seed)).statements)
            for (const crn::RoomCommand &command : statement.room) {
                if (command.action == crn::RoomAction::fluoro_pedal) {
                    presses += command.values[0] == 1;
                    fluoro = command.values[0];
                }
                if (command.action == crn::RoomAction::acquire_pedal) cine = command.values[0];
            }
        assert_int_equal(fluoro, 0);
        assert_int_equal(cine, 0);
        assert_true(presses >= 1);
    }
}

void expectations_are_left_out(void **)
{
    for (const crn::Statement &statement : played("expert:1").statements)
        assert_false(statement.expectation.has_value());
}

void hands_have_a_skill_and_a_seed(void **)
{
    assert_int_equal(crn::read_hands("novice:12").seed, 12);
    const struct {
        const char *word, *message;
    } mistakes[] = {{"novise:1", "did you mean 'novice'"},
                    {"novice", "such as novice:7"},
                    {"novice:", "such as novice:7"},
                    {"novice:x", "such as novice:7"},
                    {"novice:-1", "such as novice:7"}};
    for (const auto &mistake : mistakes) try {
            crn::read_hands(mistake.word);
            fail_msg("%s is accepted", mistake.word);
        } catch (const std::runtime_error &error) {
            assert_non_null(std::strstr(error.what(), mistake.message));
        }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_same_seed_gives_the_same_session),
        cmocka_unit_test(novices_make_more_motions_than_experts),
        cmocka_unit_test(every_push_ends_where_the_script_wants_it),
        cmocka_unit_test(the_pedals_end_as_in_the_script),
        cmocka_unit_test(expectations_are_left_out),
        cmocka_unit_test(hands_have_a_skill_and_a_seed),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
