#include "hil_tests/soak/shrink.hpp"
#include "host/base/interrupt.hpp"
#include "host/script/tool.hpp"
#include <algorithm>
#include <chrono>
#include <sstream>

namespace soak
{

namespace
{

using Clock = std::chrono::steady_clock;

std::vector<std::string> words_of(const std::string &line)
{
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

std::string join(const std::vector<std::string> &words, const char *between)
{
    std::string line;
    for (const std::string &word : words) line += (line.empty() ? "" : between) + word;
    return line;
}

// "a while b" -> a, b
std::vector<std::string> parts_of(const std::string &line)
{
    std::vector<std::string> parts;
    std::string part;
    for (const std::string &word : words_of(line)) {
        if (word != "while") {
            part += (part.empty() ? "" : " ") + word;
            continue;
        }
        parts.push_back(part);
        part.clear();
    }
    parts.push_back(part);
    return parts;
}

// Holds the shortest session so far that still exceeds the limit, and the numbers of trials and seconds that
// are left.
class Shrinker
{
  public:
    Shrinker(const DrawnSession &session, const Verdict &found,
             const std::function<Verdict(const DrawnSession &)> &judge, const ShrinkLimits &limits)
        : judge_(judge), limits_(limits), best_{session, found, 0}
    {
    }

    Shrunk run()
    {
        cut_the_end();
        for (bool goes_on = true; goes_on && !is_spent();) {
            goes_on = leave_out_lines();
            goes_on = leave_out_tools() || goes_on;
            goes_on = make_plainer() || goes_on;
        }
        return best_;
    }

  private:
    bool is_spent() const
    {
        return best_.trials >= limits_.trials || crn::is_interrupted() ||
               std::chrono::duration<double>(Clock::now() - begin_).count() > limits_.seconds;
    }

    // Judges the shorter session and returns true if it exceeds the same limit as the original session; the
    // shorter session is then the best so far.
    bool accept(const DrawnSession &shorter)
    {
        if (is_spent() || shorter.lines.empty() || shorter.tools.empty()) return false;
        best_.trials++;
        const Verdict verdict = judge_(shorter);
        if (verdict.was_interrupted || verdict.broken != best_.verdict.broken) return false;
        best_.session = shorter;
        best_.verdict = verdict;
        return true;
    }

    bool accept_without(std::size_t first, std::size_t count)
    {
        DrawnSession shorter = best_.session;
        const auto at = shorter.lines.begin() + static_cast<std::ptrdiff_t>(first);
        shorter.lines.erase(at, at + static_cast<std::ptrdiff_t>(count));
        return accept(shorter);
    }

    // The session ends at the statement in which it exceeds the limit, so later statements have no effect and
    // can be removed.
    void cut_the_end()
    {
        for (std::size_t count = best_.session.lines.size() / 2; count > 0;) {
            if (count < best_.session.lines.size() &&
                accept_without(best_.session.lines.size() - count, count))
                continue;
            count /= 2;
        }
    }

    // Removes blocks of lines from the script; the first block is half of the lines, and the last blocks are
    // single lines (Zeller's delta debugging, complements only).
    bool leave_out_lines()
    {
        bool is_shorter = false;
        for (std::size_t size = std::max<std::size_t>(best_.session.lines.size() / 2, 1); size > 0; size /= 2)
            for (std::size_t first = 0; first < best_.session.lines.size();) {
                const std::size_t count = std::min(size, best_.session.lines.size() - first);
                if (accept_without(first, count))
                    is_shorter = true;
                else
                    first += count;
            }
        return is_shorter;
    }

    bool leave_out_tools()
    {
        bool is_shorter = false;
        for (std::size_t k = best_.session.tools.size(); k-- > 0 && best_.session.tools.size() > 1;)
            is_shorter = accept(without_tool(best_.session, k)) || is_shorter;
        while (!best_.session.stents.empty()) {
            DrawnSession shorter = best_.session;
            shorter.stents.clear();
            std::erase(shorter.lines, "load stent");
            if (!accept(shorter)) break;
            is_shorter = true;
        }
        return is_shorter;
    }

    bool make_plainer()
    {
        bool is_shorter = false;
        for (std::size_t i = 0; i < best_.session.lines.size(); i++)
            for (const std::string &line : plainer(best_.session.lines[i])) {
                DrawnSession shorter = best_.session;
                shorter.lines[i] = line;
                if (!accept(shorter)) continue;
                is_shorter = true;
                break;
            }
        return is_shorter;
    }

    const std::function<Verdict(const DrawnSession &)> &judge_;
    const ShrinkLimits limits_;
    const Clock::time_point begin_ = Clock::now();
    Shrunk best_;
};

// Returns a statement of a session script in the form that it needs after the given tool has been removed
// from the session. If the statement names the removed tool, the returned statement is an empty text. In all
// other statements, each tool outside the removed tool gets the name or number of the next inner tool.
std::string part_without(const std::string &part, std::size_t tool)
{
    std::vector<std::string> words = words_of(part);
    for (std::size_t i = 0; i < words.size(); i++) {
        std::size_t number = 0;
        while (number < crn::session_tools_max && words[i] != crn::tool_name(number)) number++;
        const bool is_name = number < crn::session_tools_max;
        const bool is_numbered = words[i] == "tool" && i + 1 < words.size();
        if (is_numbered) number = static_cast<std::size_t>(std::atoi(words[i + 1].c_str())) - 1;
        if (!is_name && !is_numbered) continue;
        if (number == tool) return "";
        if (number < tool) continue;
        (is_numbered ? words[i + 1] : words[i]) =
            is_numbered ? std::to_string(number) : crn::tool_name(number - 1);
    }
    return join(words, " ");
}

// Halves the first number that is followed by the word `unit` and is not between -least and +least. Returns
// the changed text, or no text if there is no such number.
std::vector<std::string> halved(const std::string &part, const std::string &unit, int least)
{
    std::vector<std::string> words = words_of(part);
    for (std::size_t i = 1; i < words.size(); i++) {
        if (words[i] != unit) continue;
        const int number = std::atoi(words[i - 1].c_str());
        if (std::abs(number) < least) continue;
        words[i - 1] = std::to_string(number / 2);
        return {join(words, " ")};
    }
    return {};
}

} // namespace

DrawnSession without_tool(const DrawnSession &session, std::size_t tool)
{
    DrawnSession shorter = session;
    shorter.tools.erase(shorter.tools.begin() + static_cast<std::ptrdiff_t>(tool));
    shorter.lines.clear();
    for (const std::string &line : session.lines) {
        std::vector<std::string> parts;
        for (const std::string &part : parts_of(line)) {
            const std::string left = part_without(part, tool);
            if (!left.empty()) parts.push_back(left);
        }
        if (!parts.empty()) shorter.lines.push_back(join(parts, " while "));
    }
    return shorter;
}

std::vector<std::string> plainer(const std::string &line)
{
    const std::vector<std::string> parts = parts_of(line);
    std::vector<std::string> forms;
    if (parts.size() > 1) forms = parts; // one of the hands alone
    for (std::size_t i = 0; i < parts.size(); i++) {
        const auto add = [&](const std::string &plain) {
            std::vector<std::string> changed = parts;
            changed[i] = plain;
            forms.push_back(join(changed, " while "));
        };
        const std::size_t strokes = parts[i].find(" in strokes");
        if (strokes != std::string::npos) add(parts[i].substr(0, strokes));
        for (const std::string &half : halved(parts[i], "mm", 2)) add(half);
        for (const std::string &half : halved(parts[i], "deg", 20)) add(half);
        for (const std::string &half : halved(parts[i], "ms", 40)) add(half);
        for (const std::string &half : halved(parts[i], "bar", 2)) add(half);
    }
    return forms;
}

Shrunk shrink(const DrawnSession &session, const Verdict &found,
              const std::function<Verdict(const DrawnSession &)> &judge, const ShrinkLimits &limits)
{
    return Shrinker(session, found, judge, limits).run();
}

} // namespace soak
