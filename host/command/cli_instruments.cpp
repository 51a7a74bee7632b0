// cournand instruments
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/command/cli.hpp"
#include "host/report/instrument_list.hpp"
#include <cstdio>

namespace crn
{

int command_instruments(const InstrumentsOptions &options)
{
    std::vector<NamedPath> inputs;
    for (const std::string &file : options.files) inputs.push_back({"the list", split_preset(file).first});
    check_outputs(inputs, {{"--json", options.json}, {"--png", options.png}, {"--table", options.table}});
    const std::vector<ListedInstrument> list = list_instruments(options.files, options.preset);
    say(stdout, "%s", instruments_text(list).c_str());
    if (!options.json.empty()) write_whole_file(options.json, instruments_json(list));
    if (!options.png.empty()) {
        std::string error;
        if (!write_png(options.png, instruments_picture(list), error)) throw std::runtime_error(error);
    }
    if (!options.table.empty()) write_instruments_table(options.table, list);
    return 0;
}

} // namespace crn
