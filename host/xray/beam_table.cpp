// Computes the energies and weights of Gauss's quadrature for an X-ray spectrum. Stieltjes' recurrence gives
// the polynomials that are orthogonal under the discrete weights of the spectrum. Each root of a polynomial
// is found by bisection between two roots of the previous polynomial, and Christoffel's sum gives the
// weights.
#include "host/xray/beam_table.hpp"
#include "host/xray/float_math.hpp"
#include <cmath>
#include <vector>

namespace crn
{
namespace
{

constexpr int low_count = 2,
              high_count = beam_energy_count - low_count; // energies below and above iodine's edge
constexpr int first_high = 18;                            // 33.5 keV
constexpr double reference_tissue_cm = 10.0, reference_contrast_cm = 0.1;
constexpr double log2_q10mm_per_cm = 1.44269504088896340736 / 10240.0;

// Computes the polynomials p_0 .. p_n that are orthogonal to each other at the given points x under the
// weights w.
class Orthogonal
{
  public:
    Orthogonal(const std::vector<double> &x, const std::vector<double> &w, int count)
    {
        std::vector<double> p(x.size(), 1.0), before(x.size(), 0.0);
        double norm_before = 0.0;
        for (int k = 0; k < count; ++k) {
            double norm = 0.0, moment = 0.0;
            for (std::size_t i = 0; i < x.size(); ++i) {
                norm += w[i] * p[i] * p[i];
                moment += w[i] * x[i] * p[i] * p[i];
            }
            a_.push_back(moment / norm);
            b_.push_back(k > 0 ? norm / norm_before : 0.0);
            norm_.push_back(norm);
            for (std::size_t i = 0; i < x.size(); ++i) {
                const double next = (x[i] - a_[k]) * p[i] - b_[k] * before[i];
                before[i] = p[i];
                p[i] = next;
            }
            norm_before = norm;
        }
    }

    double value(int degree, double x) const
    {
        double p = 1.0, before = 0.0;
        for (int k = 0; k < degree; ++k) {
            const double next = (x - a_[k]) * p - b_[k] * before;
            before = p;
            p = next;
        }
        return p;
    }

    double weight(double x) const
    {
        double sum = 0.0;
        for (std::size_t k = 0; k < norm_.size(); ++k) {
            const double p = value(static_cast<int>(k), x);
            sum += p * p / norm_[k];
        }
        return 1.0 / sum;
    }

    // Returns the roots of the last polynomial in ascending order; all roots must lie between `low` and
    // `high`.
    std::vector<double> roots(double low, double high) const
    {
        std::vector<double> found;
        for (int degree = 1; degree <= static_cast<int>(norm_.size()); ++degree) {
            std::vector<double> borders = found;
            borders.insert(borders.begin(), low);
            borders.push_back(high);
            found.clear();
            for (int k = 0; k < degree; ++k) found.push_back(root(degree, borders[k], borders[k + 1]));
        }
        return found;
    }

  private:
    double root(int degree, double low, double high) const
    {
        const bool rises = value(degree, low) < 0.0;
        for (int i = 0; i < 52; ++i) {
            const double middle = 0.5 * (low + high);
            ((value(degree, middle) < 0.0) == rises ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }

    std::vector<double> a_, b_, norm_;
};

// Returns a material's attenuation in 1/cm at an energy between the table's entries `first` and `last`, by
// interpolation that is linear in the logarithms of energy and attenuation.
double attenuation_at(int material, double energy, int first, int last)
{
    int i = static_cast<int>(energy - energy_keV(0));
    i = i < first ? first : i > last - 1 ? last - 1 : i;
    const float *row = attenuation_per_cm[material];
    const double low = log2_double(row[i]), high = log2_double(row[i + 1]);
    const double from = log2_double(energy_keV(i)), to = log2_double(energy_keV(i + 1));
    return exp2_double(low + (high - low) * (log2_double(energy) - from) / (to - from));
}

struct Part {
    int first, last;            // of the table's energies
    int slot, count;            // place among the beam's energies
    std::vector<double> signal; // of the reference thickness, per table energy
};

// The attenuation of a material jumps at a K edge, so a material with a K edge among the beam's energies has
// no smooth curve. For a material with a K edge, each energy of the table is assigned to the nearest energy
// of the beam. For each of the quadrature's energies, the attenuation is averaged over the energies assigned
// to it, weighted by the signal.
void average_cells(const Part &part, int material, BeamTable &table, const std::vector<double> &weights)
{
    double sum = 0.0, mass = 0.0, border = 0.0, passed = 0.0;
    int k = part.count - 1; // lowest energy last: x = 1/sqrt(E) ascends
    border = weights[k];
    for (int i = part.first; i <= part.last; ++i) {
        double left = part.signal[i];
        while (k > 0 && passed + left >= border) {
            const double share = border - passed;
            sum += share * attenuation_per_cm[material][i];
            mass += share;
            table.log2_per_q10mm[material][part.slot + k] =
                static_cast<float>(sum / mass * log2_q10mm_per_cm);
            passed += share;
            left -= share;
            sum = mass = 0.0;
            border += weights[--k];
        }
        sum += left * attenuation_per_cm[material][i];
        mass += left;
        passed += left;
    }
    table.log2_per_q10mm[material][part.slot] = static_cast<float>(sum / mass * log2_q10mm_per_cm);
}

void fill_part(const Part &part, BeamTable &table)
{
    std::vector<double> x, w;
    for (int i = part.last; i >= part.first; --i) {
        if (!(part.signal[i] > 0.0)) continue;
        x.push_back(1.0 / std::sqrt(energy_keV(i)));
        w.push_back(part.signal[i]);
    }
    const Orthogonal polynomials(x, w, part.count);
    const std::vector<double> places = polynomials.roots(x.front(), x.back());
    std::vector<double> weights;
    for (int k = 0; k < part.count; ++k) {
        weights.push_back(polynomials.weight(places[k]));
        const double energy = 1.0 / (places[k] * places[k]);
        table.energy_keV[part.slot + k] = energy;
        for (int m = 0; m < material_count; ++m)
            table.log2_per_q10mm[m][part.slot + k] =
                static_cast<float>(attenuation_at(m, energy, part.first, part.last) * log2_q10mm_per_cm);
    }
    for (int m = 0; m < material_count; ++m)
        if (edge_keV[m] > 0.0f) average_cells(part, m, table, weights);
    for (int k = 0; k < part.count; ++k) {
        const auto at = [&](Material m) {
            return static_cast<double>(table.log2_per_q10mm[static_cast<int>(m)][part.slot + k]) * 10240.0;
        };
        const double depth = reference_tissue_cm * at(Material::soft_tissue) +
                             reference_contrast_cm * at(Material::iohexol_350);
        table.share[part.slot + k] = static_cast<float>(weights[k] * exp2_double(depth));
    }
}

void count_quanta(const Spectrum &open, BeamTable &table)
{
    const Spectrum patient = behind(open, Material::soft_tissue, 20.0);
    double signal = 0.0, first = 0.0, second = 0.0;
    for (int i = 0; i < energy_count; ++i) {
        const double energy = energy_keV(i), absorbed = scintillator_absorption(i);
        signal += open[i] * absorbed * energy;
        first += patient[i] * absorbed * energy;
        second += patient[i] * absorbed * energy * energy;
    }
    table.quantum_keV = second / first;
    table.quanta_mm2_mAs = signal / table.quantum_keV;
    table.air_kerma_uGy_mAs = air_kerma_uGy(open);
    table.patient_nGy_quantum_mm2 = air_kerma_uGy(patient) * 1e3 / (first / table.quantum_keV);
}

} // namespace

BeamTable make_beam_table(double tube_voltage_kV, double copper_mm)
{
    BeamTable table;
    const Spectrum open = tube_spectrum(tube_voltage_kV, copper_mm);
    std::vector<double> signal(energy_count);
    double total = 0.0;
    for (int i = 0; i < energy_count; ++i) {
        signal[i] = open[i] * scintillator_absorption(i) * energy_keV(i);
        total += signal[i];
    }
    for (int i = 0; i < energy_count; ++i) {
        const double depth =
            reference_tissue_cm * attenuation_per_cm[static_cast<int>(Material::soft_tissue)][i] +
            reference_contrast_cm * attenuation_per_cm[static_cast<int>(Material::iohexol_350)][i];
        signal[i] *= exp_double(-depth) / total;
    }
    fill_part({0, first_high - 1, 0, low_count, signal}, table);
    fill_part({first_high, energy_count - 1, low_count, high_count, signal}, table);
    count_quanta(open, table);
    return table;
}

BeamTable make_line_table(std::span<const double> energies_keV, std::span<const double> shares)
{
    BeamTable table;
    double total = 0.0;
    for (double share : shares) total += share;
    for (std::size_t k = 0; k < energies_keV.size() && k < beam_energy_count; ++k) {
        table.energy_keV[k] = energies_keV[k];
        table.share[k] = static_cast<float>(shares[k] / total);
        for (int m = 0; m < material_count; ++m)
            table.log2_per_q10mm[m][k] = static_cast<float>(
                attenuation_at(m, energies_keV[k], 0, energy_count - 1) * log2_q10mm_per_cm);
    }
    return table;
}

} // namespace crn
