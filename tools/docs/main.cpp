// Writes the generated tables of docs/wire.md, docs/usb.md and docs/faults.md from their definitions in the
// source code.
//   docs --write    puts the tables between the marks in the documents
//   docs --check    exit 1 when a document is not current
//   docs --dissector FILE   writes the Wireshark dissector
#include "host/base/number_text.hpp"
#include "shared/version.h"
#include "shared/wire/hid.h"
#include "shared/wire/wire.h"
#include "tools/docs/dissector.hpp"
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

namespace
{

// Breaks a paragraph into lines of at most 120 characters, and returns them as one text in which every line
// ends with a newline.
std::string wrapped(const std::string &text)
{
    constexpr std::size_t letters_max = 120;
    std::istringstream words(text);
    std::string line, result;
    for (std::string word; words >> word; line += (line.empty() ? "" : " ") + word) {
        if (line.empty() || line.size() + 1 + word.size() <= letters_max) continue;
        result += line + "\n";
        line.clear();
    }
    return result + line + "\n";
}

std::string bar_safe(const char *text)
{
    std::string result;
    for (const char *c = text; *c; c++) result += *c == '|' ? std::string("\\|") : std::string(1, *c);
    return result;
}

std::string row(std::initializer_list<std::string> cells)
{
    std::string result = "|";
    for (const std::string &cell : cells) result += " " + cell + " |";
    return result + "\n";
}

std::string message_tables()
{
    const std::string hash = crn::hex_text(crn_wire_schema_hash());
    std::string out = "Protocol " + std::to_string(CRN_WIRE_PROTOCOL_MAJOR) + "." +
                      std::to_string(CRN_WIRE_PROTOCOL_MINOR) + ", schema hash `" + hash + "`.\n\n";
    const char *const head = "\n| field | type | unit | meaning |\n|---|---|---|---|\n";
#define RECORD(name, text)                                                                                   \
    out += "### Record `" #name "` (at most " + std::to_string(CRN_WIRE_BYTES_##name) + " bytes)\n" +        \
           wrapped(text ".") + head;
#define MESSAGE(name, type, direction, text)                                                                 \
    out += "### 0x" + crn::hex_text(type, 2) + " `" #name "` (from " direction ", up to " +                  \
           std::to_string(CRN_WIRE_BYTES_##name) + " bytes)\n" + wrapped(text ".") + head;
#define FIELD(owner, type, name, unit, text) out += row({"`" #name "`", #type, unit, bar_safe(text)});
#define ARRAY(owner, type, name, max, unit, text)                                                            \
    out += row({"`" #name "`", "u16 count, then count × " #type ", at most " #max, unit, bar_safe(text)});
#define LIST(owner, type, name, max, unit, text)                                                             \
    out += row({"`" #name "`", "u8 count, then count × " #type ", at most " #max, unit, bar_safe(text)});
#define END(owner) out += "\n";
#define CHOICE(name, text)                                                                                   \
    out += "### Choice `" #name "` (at most " + std::to_string(CRN_WIRE_BYTES_##name) + " bytes)\n" +        \
           wrapped(text ".") + "A u8, the kind, then the record that has it.\n\n" +                          \
           "| kind | record | meaning |\n|---|---|---|\n";
#define OPTION(choice, record, kind, text) out += row({#kind, "`" #record "`", bar_safe(text)});
#define CHOICE_END(choice) out += "\n";
#include "shared/wire/wire_messages.def"
    return out;
}

std::string report_tables()
{
    const std::string hash = crn::hex_text(crn_hid_report_hash());
    std::string out = "Report hash `" + hash + "`.\n\n";
    const char *const head = "\n| field | type | unit | meaning |\n|---|---|---|---|\n";
#define HID_RECORD(name, text)                                                                               \
    out += "### Record `" #name "` (" + std::to_string(CRN_HID_BYTES_##name) + " bytes)\n" +                 \
           wrapped(text ".") + head;
#define HID_REPORT(name, id, kind, text)                                                                     \
    out += "### Report " #id " `" #name "` (" #kind ", " + std::to_string(CRN_HID_BYTES_##name) +            \
           " bytes behind the id)\n" + wrapped(text ".") + head;
#define HID_FIELD(owner, type, name, unit, text) out += row({"`" #name "`", #type, unit, bar_safe(text)});
#define HID_ARRAY(owner, type, name, count, unit, text)                                                      \
    out += row({"`" #name "`", #count " × " #type, unit, bar_safe(text)});
#define HID_END(owner) out += "\n";
#include "shared/wire/hid_reports.def"
    return out;
}

std::string endpoint_table()
{
    std::string out = "| interface | endpoint | type | packet, full speed | bInterval | packet, high speed | "
                      "bInterval | for |\n"
                      "|---|---|---|---|---|---|---|---|\n";
    const std::string CRN_UDC_INTERRUPT = "interrupt", CRN_UDC_BULK = "bulk";
#define USB_INTERFACE(NAME, class, text)                                                                     \
    out += row({"`" #NAME "`", "", "class " #class, "", "", "", "", bar_safe(text)});
#define USB_ENDPOINT(INTERFACE, NAME, address, type, full_bytes, full_interval, high_bytes, high_interval,   \
                     text)                                                                                   \
    out +=                                                                                                   \
        row({"", #address, type, #full_bytes, #full_interval, #high_bytes, #high_interval, bar_safe(text)});
#include "firmware/app/usb/usb_table.def"
    return out;
}

std::string fault_table()
{
    std::string out =
        "| code | fault | effect | what happened | detection | time to safe | test | what to do |\n"
        "|---|---|---|---|---|---|---|---|\n";
#define FAULT(NAME, code, effect, safe_ms, test, text, detection, remedy)                                    \
    out += row({#code, "`" #NAME "`", effect, bar_safe(text), bar_safe(detection),                           \
                (safe_ms) > 0 ? #safe_ms " ms" : "no force at stake", "`" test "`", bar_safe(remedy)});
#include "shared/wire/wire_faults.def"
    return out;
}

std::string reject_table()
{
    std::string out = "| code | name | why | what to do |\n|---|---|---|---|\n";
#define REJECT(NAME, code, text, remedy) out += row({#code, "`" #NAME "`", bar_safe(text), bar_safe(remedy)});
#include "shared/wire/wire_faults.def"
    return out;
}

std::string exchange_table()
{
    std::string out = "| answer | name | what it means | what to do |\n|---|---|---|---|\n";
#define EXCHANGE(NAME, number, text, remedy)                                                                 \
    out += row({#number, "`" #NAME "`", bar_safe(text), bar_safe(remedy)});
#include "shared/wire/wire_exchanges.def"
    return out;
}

std::string read_file(const std::string &path)
{
    std::ifstream stream(path);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

// Replaces the text between "<!-- begin NAME -->" and "<!-- end NAME -->" in a document and returns the new
// document. Returns an empty text if the marks "begin NAME" and "end NAME" are missing.
std::string with_table(const std::string &document, const std::string &name, const std::string &table)
{
    const std::string begin = "<!-- begin " + name + " -->\n", end = "<!-- end " + name + " -->";
    const std::size_t from = document.find(begin), to = document.find(end);
    if (from == std::string::npos || to == std::string::npos || to < from) return "";
    return document.substr(0, from + begin.size()) + table + document.substr(to);
}

bool handle(const std::string &path, const std::string &name, const std::string &table, bool write)
{
    const std::string old = read_file(path);
    const std::string wanted = with_table(old, name, table);
    if (wanted.empty()) {
        std::cerr << path << ": the marks '<!-- begin " << name << " -->' and '<!-- end " << name
                  << " -->' are missing\n";
        return false;
    }
    if (old == wanted) return true;
    if (write) return static_cast<bool>(std::ofstream(path) << wanted);
    std::cerr << path << ": the table '" << name << "' is not current; run `make docs`\n";
    return false;
}

bool write_dissector(const std::string &path)
{
    const std::string runtime = read_file("tools/docs/dissector.lua");
    if (runtime.empty())
        std::cerr << "tools/docs/dissector.lua: cannot be read; run from the repository's root\n";
    if (!runtime.empty() && std::ofstream(path) << dissector_tables() << runtime) return true;
    std::cerr << path << ": not written\n";
    return false;
}

} // namespace

int main(int argc, char **argv)
{
    const std::string mode = argc >= 2 ? argv[1] : "";
    if (mode == "--version") {
        std::cout << "docs " CRN_VERSION " (Cournand)\n";
        return 0;
    }
    if (mode == "--dissector" && argc == 3) return write_dissector(argv[2]) ? 0 : 1;
    if (argc != 2 || (mode != "--write" && mode != "--check")) {
        std::cerr << "usage: docs --write | --check | --dissector FILE | --version   (from the repository's "
                     "root)\n";
        return 2;
    }
    const bool write = mode == "--write";
    bool ok = handle("docs/wire.md", "messages", message_tables(), write);
    ok = handle("docs/usb.md", "endpoints", endpoint_table(), write) && ok;
    ok = handle("docs/usb.md", "reports", report_tables(), write) && ok;
    ok = handle("docs/faults.md", "faults", fault_table(), write) && ok;
    ok = handle("docs/faults.md", "refusals", reject_table(), write) && ok;
    ok = handle("docs/faults.md", "exchanges", exchange_table(), write) && ok;
    return ok ? 0 : 1;
}
