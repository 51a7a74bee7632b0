// seldinger instruments
#include "host/app/cli.hpp"
#include "host/app/instrument_list.hpp"
#include "host/model/text.hpp"
#include <cstdio>
#include <fstream>

namespace seld
{

int command_instruments(const InstrumentsOptions &options)
{
    const std::vector<ListedInstrument> list = list_instruments(options.files, options.preset);
    std::fputs(instruments_text(list).c_str(), stdout);
    if (!options.json.empty()) {
        std::ofstream stream(options.json);
        stream << instruments_json(list);
        stream.flush();
        if (!stream) {
            throw FileError(options.json, 0, 0,
                            "cannot write; check that the folder exists and the disk has room");
        }
    }
    if (!options.png.empty()) {
        std::string error;
        if (!write_png(options.png, instruments_picture(list), error)) throw std::runtime_error(error);
    }
    if (!options.table.empty()) write_instruments_table(options.table, list);
    return 0;
}

} // namespace seld
