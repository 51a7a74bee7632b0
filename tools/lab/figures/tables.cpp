#include "tools/lab/figures/tables.hpp"
#include "host/base/number_text.hpp"
#include "tools/lab/figures/thesis_values.hpp"
#include <nlohmann/json.hpp>

namespace vcsim3
{
namespace
{

std::string optional_number(const std::optional<double> &value)
{
    return value ? crn::number_text(*value, 4) : "";
}

double direct_time_s(const Study &study)
{
    for (const TimingResult &time : study.times)
        if (time.direct_s > 0.0) return time.direct_s;
    return 0.0;
}

double direct_instructions(const Study &study)
{
    for (const TimingResult &time : study.times)
        if (time.direct_s > 0.0) return time.instructions;
    return 0.0;
}

} // namespace

Table compression_table(const Study &study)
{
    Table table{{"mode", "compression_pct", "at_rest_pct", "largest_pct", "thesis_pct", "contacts",
                 "handle_N", "depth_max_mm", "sound"},
                {}};
    for (const CompressionResult &run : study.runs)
        table.rows.push_back({run.name, crn::number_text(run.pushing_pct, 4),
                              crn::number_text(run.holding_pct, 4), crn::number_text(run.largest_pct, 4),
                              optional_number(thesis_compression_pct(run.token)),
                              std::to_string(run.contacts), crn::number_text(run.handle_N, 4),
                              crn::number_text(run.depth_max_mm, 4), run.is_sound ? "yes" : "burst"});
    return table;
}

Table times_table(const Study &study)
{
    Table table{{"mode", "integrator_us", "constraints_us", "cosserat_us", "collisions_us", "step_us",
                 "steps_per_ms", "us_per_simulated_ms", "ratio_to_direct", "instructions_per_simulated_ms",
                 "instruction_ratio", "thesis_step_ms"},
                {}};
    const double direct_s = direct_time_s(study), direct_count = direct_instructions(study);
    for (const TimingResult &time : study.times) {
        const PhaseTimes &s = time.step;
        const bool is_baseline = time.direct_s == 0.0;
        const auto phase = [&](double seconds) {
            return is_baseline ? crn::number_text(seconds * 1e6, 3) : "";
        };
        const auto thesis = thesis_times(time.token);
        const double count = time.instructions * time.steps_per_ms;
        table.rows.push_back(
            {time.name, phase(s.integrator_s), phase(s.constraints_s), phase(s.cosserat_s),
             phase(s.collisions_s), crn::number_text(time.total_s() * 1e6, 3),
             std::to_string(time.steps_per_ms), crn::number_text(time.per_ms_s() * 1e6, 3),
             direct_s > 0.0 ? crn::number_text(time.per_ms_s() / direct_s, 3) : "",
             count > 0.0 ? crn::number_text(count, 6) : "",
             count > 0.0 && direct_count > 0.0 ? crn::number_text(count / direct_count, 3) : "",
             thesis ? crn::number_text(thesis->total_ms, 4) : ""});
    }
    return table;
}

Table shape_table(const Study &study)
{
    Table table{{"mode", "node", "x_mm", "y_mm", "z_mm", "touching"}, {}};
    for (const CompressionResult &run : study.runs)
        for (std::size_t i = 0; i < run.shape.size(); i++) {
            const Vector mm = run.shape[i].position_m * 1e3;
            table.rows.push_back({run.name, std::to_string(i), crn::number_text(mm.x(), 6),
                                  crn::number_text(mm.y(), 6), crn::number_text(mm.z(), 6),
                                  run.shape[i].is_touching ? "1" : "0"});
        }
    return table;
}

Table preset_table()
{
    Table table{{"preset", "instrument", "E_Pa", "radius_mm", "density_kg_m3", "Kp_N", "EI_N_m2",
                 "mass_scale", "mass_kg_m", "inertia_scale", "steps_per_ms", "step_ratio"},
                {}};
    for (const Preset &p : presets())
        table.rows.push_back({p.token, p.instrument, crn::number_text(p.young_Pa(), 4),
                              crn::number_text(p.radius_m() * 1e3, 4), crn::number_text(p.density_kg_m3(), 4),
                              crn::number_text(p.parallel_N(), 4), crn::number_text(p.bend_N_m2(), 3),
                              crn::number_text(p.mass_scale, 4), crn::number_text(p.mass_kg_per_m(), 3),
                              crn::number_text(p.inertia_scale, 4), std::to_string(p.substeps),
                              crn::number_text(step_ratio(p, preset_element_m, p.substeps), 3)});
    return table;
}

Table stability_table(const Study &study)
{
    Table table{{"preset", "steps_per_ms", "smallest_penalty", "smallest_10_local", "smallest_1_global"}, {}};
    for (const StabilityRow &row : study.stability)
        table.rows.push_back({row.preset->token, std::to_string(row.preset->substeps),
                              std::to_string(row.penalty), std::to_string(row.local10),
                              std::to_string(row.global)});
    return table;
}

std::string to_tsv(const Table &table)
{
    std::string text;
    const auto add = [&](const std::vector<std::string> &cells) {
        for (std::size_t i = 0; i < cells.size(); i++) text += (i ? "\t" : "") + cells[i];
        text += "\n";
    };
    add(table.head);
    for (const std::vector<std::string> &row : table.rows) add(row);
    return text;
}

std::string to_html(const Table &table)
{
    std::string text = "<table>\n";
    const auto add = [&](const std::vector<std::string> &cells, const char *cell) {
        text += "<tr>";
        for (const std::string &content : cells)
            text += std::string("<") + cell + ">" + content + "</" + cell + ">";
        text += "</tr>\n";
    };
    std::vector<std::string> head = table.head;
    for (std::string &name : head)
        for (char &letter : name)
            if (letter == '_') letter = ' ';
    add(head, "th");
    for (const std::vector<std::string> &row : table.rows) add(row, "td");
    return text + "</table>\n";
}

std::string to_json(const Study &study)
{
    const auto rows_of = [](const Table &table) {
        nlohmann::json rows = nlohmann::json::array();
        for (const std::vector<std::string> &row : table.rows) {
            nlohmann::json object;
            for (std::size_t i = 0; i < row.size(); i++) object[table.head[i]] = row[i];
            rows.push_back(object);
        }
        return rows;
    };
    nlohmann::json all;
    all["preset"] = study.preset->token;
    all["elements"] = study.protocol.element_count;
    all["element_mm"] = study.protocol.element_m * 1e3;
    all["compression"] = rows_of(compression_table(study));
    all["times"] = rows_of(times_table(study));
    all["presets"] = rows_of(preset_table());
    all["stability"] = rows_of(stability_table(study));
    all["order_faults"] = order_faults(study);
    return all.dump(2) + "\n";
}

} // namespace vcsim3
