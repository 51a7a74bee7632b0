#include "tools/chip/mnemonic.hpp"
#include <unordered_map>

namespace chip
{

namespace
{

const std::unordered_map<std::string, Form> forms = {
    {"add", Form::compute},
    {"addw", Form::compute},
    {"sub", Form::compute},
    {"subw", Form::compute},
    {"adc", Form::compute},
    {"sbc", Form::compute},
    {"rsb", Form::compute},
    {"and", Form::compute},
    {"orr", Form::compute},
    {"eor", Form::compute},
    {"bic", Form::compute},
    {"orn", Form::compute},
    {"adr", Form::move},
    {"mov", Form::move},
    {"movw", Form::move},
    {"movt", Form::move},
    {"mvn", Form::move},
    {"neg", Form::move},
    {"cmp", Form::compare},
    {"cmn", Form::compare},
    {"tst", Form::compare},
    {"teq", Form::compare},
    {"lsl", Form::shift},
    {"lsr", Form::shift},
    {"asr", Form::shift},
    {"ror", Form::shift},
    {"rrx", Form::shift},
    {"ubfx", Form::bits},
    {"sbfx", Form::bits},
    {"bfi", Form::bits},
    {"bfc", Form::bits},
    {"uxtb", Form::bits},
    {"uxth", Form::bits},
    {"sxtb", Form::bits},
    {"sxth", Form::bits},
    {"uxtab", Form::bits},
    {"uxtah", Form::bits},
    {"sxtab", Form::bits},
    {"sxtah", Form::bits},
    {"rev", Form::bits},
    {"rev16", Form::bits},
    {"revsh", Form::bits},
    {"rbit", Form::bits},
    {"clz", Form::bits},
    {"ssat", Form::bits},
    {"usat", Form::bits},
    {"qadd", Form::bits},
    {"qsub", Form::bits},
    {"qdadd", Form::bits},
    {"qdsub", Form::bits},
    {"pkhbt", Form::bits},
    {"pkhtb", Form::bits},
    {"sadd16", Form::bits},
    {"ssub16", Form::bits},
    {"qadd16", Form::bits},
    {"qsub16", Form::bits},
    {"uadd8", Form::bits},
    {"sel", Form::bits},
    {"usad8", Form::bits},
    {"uqsub8", Form::bits},
    {"usub8", Form::bits},
    {"mul", Form::product},
    {"smull", Form::product},
    {"umull", Form::product},
    {"smmul", Form::product},
    {"smmulr", Form::product},
    {"smulbb", Form::product},
    {"smulbt", Form::product},
    {"smultb", Form::product},
    {"smultt", Form::product},
    {"smulwb", Form::product},
    {"smulwt", Form::product},
    {"smuad", Form::product},
    {"smuadx", Form::product},
    {"smusd", Form::product},
    {"smusdx", Form::product},
    {"mla", Form::accumulate},
    {"mls", Form::accumulate},
    {"smmla", Form::accumulate},
    {"smmlar", Form::accumulate},
    {"smmls", Form::accumulate},
    {"smmlsr", Form::accumulate},
    {"smlabb", Form::accumulate},
    {"smlabt", Form::accumulate},
    {"smlatb", Form::accumulate},
    {"smlatt", Form::accumulate},
    {"smlawb", Form::accumulate},
    {"smlawt", Form::accumulate},
    {"smlad", Form::accumulate},
    {"smladx", Form::accumulate},
    {"smlsd", Form::accumulate},
    {"smlal", Form::long_accumulate},
    {"umlal", Form::long_accumulate},
    {"umaal", Form::long_accumulate},
    {"smlald", Form::long_accumulate},
    {"smlalbb", Form::long_accumulate},
    {"smlalbt", Form::long_accumulate},
    {"smlaltb", Form::long_accumulate},
    {"smlaltt", Form::long_accumulate},
    {"sdiv", Form::divide},
    {"udiv", Form::divide},
    {"ldr", Form::load},
    {"ldrb", Form::narrow},
    {"ldrh", Form::narrow},
    {"ldrsb", Form::narrow},
    {"ldrsh", Form::narrow},
    {"ldrd", Form::load_two},
    {"str", Form::store},
    {"strb", Form::store},
    {"strh", Form::store},
    {"strd", Form::store_two},
    {"ldmia", Form::load_many},
    {"ldmdb", Form::load_many},
    {"pop", Form::load_many},
    {"stmia", Form::store_many},
    {"stmdb", Form::store_many},
    {"push", Form::store_many},
    {"b", Form::branch},
    {"bl", Form::branch},
    {"bx", Form::branch},
    {"blx", Form::branch},
    {"cbz", Form::test_branch},
    {"cbnz", Form::test_branch},
    {"tbb", Form::branch},
    {"tbh", Form::branch},
    {"nop", Form::nothing},
    {"udf", Form::nothing},
    {"bkpt", Form::nothing},
    {"dmb", Form::nothing},
};

bool is_condition(const std::string &text)
{
    static const std::string all = " eq ne cs cc mi pl vs vc hi ls ge lt gt le ";
    return text.size() == 2 && all.find(" " + text + " ") != std::string::npos;
}

std::optional<Name> plain(const std::string &text)
{
    const auto known = forms.find(text);
    if (known == forms.end()) return {};
    return Name{known->second, text};
}

} // namespace

// "bls" is a branch that "ls" makes conditional, not a "bl" that sets flags.
std::optional<Name> name_of(const std::string &mnemonic)
{
    const std::string text = mnemonic.substr(0, mnemonic.find('.'));
    if (text.starts_with("it")) return Name{Form::nothing, "it"};
    if (const auto exact = plain(text)) return exact;
    const std::string end = text.size() > 2 ? text.substr(text.size() - 2) : "";
    const std::string without = text.substr(0, text.size() - end.size());
    if (without == "b" && is_condition(end)) return Name{Form::branch, "b", false, true};
    if (text.back() == 's')
        if (auto name = plain(text.substr(0, text.size() - 1))) {
            name->sets_flags = true;
            return name;
        }
    if (!is_condition(end)) return {};
    auto name = plain(without);
    if (!name && without.size() > 1 && without.back() == 's') {
        name = plain(without.substr(0, without.size() - 1));
        if (name) name->sets_flags = true;
    }
    if (name) name->is_conditional = true;
    return name;
}

} // namespace chip
