#include "tools/patient/coronary.hpp"
#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <optional>

namespace crn::patient
{
namespace
{

enum class Side { left, right };

bool says_any(const std::string &text, std::initializer_list<const char *> words)
{
    return std::any_of(words.begin(), words.end(),
                       [&](const char *word) { return text.find(word) != text.npos; });
}

// The name in small letters, with "_" for everything else, and around it: so "_lad_" is a whole word.
std::string as_words(const std::string &name)
{
    std::string text = "_";
    for (const char c : name) {
        const auto letter = static_cast<unsigned char>(c);
        text += std::isalnum(letter) ? static_cast<char>(std::tolower(letter)) : '_';
    }
    return text + "_";
}

// The posterior descending and posterolateral arteries mostly come from the right coronary artery.
std::optional<Side> side_by_name(const std::string &name)
{
    const std::string text = as_words(name);
    if (says_any(text, {"_rca_", "posterior", "_pda_", "_plv_", "_plb_"})) return Side::right;
    if (says_any(text, {"_left_", "_lad_", "_lcx_", "_lmca_", "_lm_", "circumflex", "anterior_", "diagonal",
                        "obtuse", "septal", "intermedi"}))
        return Side::left;
    if (says_any(text, {"_right_", "conus"})) return Side::right;
    return std::nullopt;
}

std::string name_list(const std::vector<std::string> &names)
{
    std::string text;
    for (const std::string &name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
    return "[" + text + "]";
}

// No artery of another organ has such a name.
bool is_sure(const std::string &text)
{
    return says_any(text, {"coronar", "_left_main_", "interventricular", "ventricular_branch",
                           "ventricular_artery", "anterior_descending", "posterior_descending",
                           "ramus_intermed", "_lad_", "_lcx_", "_rca_", "_lmca_"});
}

} // namespace

bool is_coronary_name(const std::string &name)
{
    const std::string text = as_words(name);
    // Arteries of the arm, the leg, the gut and the nose are called circumflex, marginal and septal, too.
    if (says_any(text, {"vein", "venous", "sinus", "femoral", "humeral", "iliac", "scapul", "coli", "colon",
                        "drummond", "nasal", "cerebr"}))
        return false;
    return is_sure(text) || says_any(text, {"circumflex", "diagonal", "marginal_branch", "marginal_artery",
                                            "septal", "conus_", "_pda_", "_plv_"});
}

CoronaryBranches coronary_branches(const centreline::Tree &tree, const std::string &root_name)
{
    CoronaryBranches found;
    std::vector<std::optional<Side>> sides;
    // Other organs have marginal and diagonal arteries, too: such a name counts beside one that is sure.
    const bool has_heart =
        is_coronary_name(root_name) ||
        std::any_of(tree.branches.begin(), tree.branches.end(), [](const centreline::Branch &branch) {
            return is_coronary_name(branch.name) && is_sure(as_words(branch.name));
        });
    if (!has_heart) return found;
    for (const centreline::Branch &branch : tree.branches) { // parents come before their branches
        const bool is_root = branch.parent < 0;
        std::optional<Side> side = is_root ? std::nullopt : sides[static_cast<std::size_t>(branch.parent)];
        const bool is_whole = is_root && is_coronary_name(root_name);
        if (!side && (is_whole || is_coronary_name(branch.name))) {
            const double left_mm = branch.spheres.back().centre_mm.x() - branch.spheres.front().centre_mm.x();
            side = side_by_name(is_whole ? root_name : branch.name)
                       .value_or(left_mm < 0.0 ? Side::right : Side::left);
        }
        sides.push_back(side);
        if (side) (*side == Side::left ? found.left : found.right).push_back(branch.name);
    }
    return found;
}

std::string CoronaryBranches::scene_text() const
{
    std::string text;
    if (!left.empty()) text += "left_coronary = " + name_list(left) + "\n";
    if (!right.empty()) text += "right_coronary = " + name_list(right) + "\n";
    return text;
}

} // namespace crn::patient
