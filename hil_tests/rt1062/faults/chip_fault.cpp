#include "hil_tests/rt1062/faults/chip_fault.hpp"
#include <algorithm>

namespace hil
{

namespace
{

// A session that rests for longer than this has no other bar: the stage has switched off by itself.
constexpr double long_us = 10000, host_long_us = 70000;
constexpr std::uint32_t usb_horizon_ms = 80, stack_used_bytes = 160, dog_horizon_ms = 2700,
                        used_encoder[2] = {0, 3};

bool is_motor_register(std::uint32_t address)
{
    const std::uint32_t base = address & ~0x3fffu;
    return base == BASE_PWM2 || base == BASE_PWM3 || base == BASE_GPIO3;
}

class Draw
{
  public:
    Draw(ChipFault &drawn, const ChipSurvey &survey)
        : random_(0x1062u + drawn.seed * 7919ull), survey_(survey), drawn_(drawn), fault_(drawn.fault)
    {
        fault_.begin = 1 + random_.next() % (8000 * RT_INSTANTS_PER_us); // within a frame of the host
        fault_.end = RT_NEVER;
    }

    std::uint32_t below(std::uint32_t count) { return random_.below(count); }
    template <class T, std::size_t N> T one_of(const T (&list)[N])
    {
        return list[below(static_cast<std::uint32_t>(N))];
    }

    void lasts(double us)
    {
        lasts_us_ = us;
        fault_.end = us <= 0 ? RT_NEVER : fault_.begin + static_cast<std::uint64_t>(us * RT_INSTANTS_PER_us);
    }
    void lasts_any() { lasts(one_of({20.0, 300.0, 1500.0, 6000.0, 0.0, 0.0})); }
    bool is_at_least(double us) const { return lasts_us_ <= 0 || lasts_us_ >= us; }

    void must(Must what, SafeClass which)
    {
        drawn_.must = what;
        drawn_.safe_class = which;
    }
    void says(const std::string &what)
    {
        drawn_.what = what + text(", at %.3f ms", double(fault_.begin) / RT_INSTANTS_PER_us * 1e-3);
        if (fault_.end != RT_NEVER) drawn_.what += text(" for %.2f ms", lasts_us_ * 1e-3);
    }

    std::uint32_t some_bits()
    {
        std::uint32_t bits = 0;
        for (std::uint32_t i = 0, count = one_of({1u, 1u, 1u, 2u, 4u}); i < count; i++)
            bits |= 1u << below(32);
        return bits;
    }
    // A register that the image reads (or writes); bits are those within its width.
    std::uint32_t pick_register(bool is_written, std::uint32_t &mask)
    {
        const rt_census &census = survey_.census;
        for (;;) {
            const auto &one = census.registers[below(census.count)];
            if ((is_written ? one.writes : one.reads) == 0) continue;
            mask = one.bytes == 2 ? 0xffffu : one.bytes == 1 ? 0xffu : 0xffffffffu;
            return one.address;
        }
    }
    // Places the fault at a register, and returns the bits within its width.
    std::uint32_t take_register(bool is_written)
    {
        std::uint32_t mask = 0;
        fault_.address = pick_register(is_written, mask);
        drawn_.is_of_motor = is_motor_register(fault_.address);
        return mask;
    }
    void bits_of(std::uint32_t mask)
    {
        std::uint32_t bits = some_bits();
        if (mask == 0xffffu) bits = (bits | bits >> 16) & mask;
        const std::uint32_t how = below(3);
        (how == 0 ? fault_.clear : how == 1 ? fault_.set : fault_.flip) = bits;
        fault_.kind = RT_FAULT_READ;
        says(text("bits %08x of 0x%08x %s", bits, fault_.address,
                  how == 0   ? "stuck at 0"
                  : how == 1 ? "stuck at 1"
                             : "inverted"));
    }
    void memory(const char *name, std::uint32_t begin, std::uint32_t end)
    {
        memory(name, std::vector<std::uint32_t>{(begin + below(end - begin)) & ~3u});
    }
    void memory(const char *name, const std::vector<std::uint32_t> &words)
    {
        fault_.kind = RT_FAULT_MEMORY;
        fault_.address = words[below(static_cast<std::uint32_t>(words.size()))];
        fault_.flip = some_bits();
        says(text("bits %08x of the %s at 0x%08x flip", fault_.flip, name, fault_.address));
    }

    rt_fault &fault() { return fault_; }
    const ChipSurvey &survey() const { return survey_; }
    ChipFault &drawn() { return drawn_; }

  private:
    Random random_;
    const ChipSurvey &survey_;
    ChipFault &drawn_;
    rt_fault &fault_;
    double lasts_us_ = 0;
};

// --- registers ---

void reg_read(Draw &draw)
{
    draw.lasts_any();
    draw.bits_of(draw.take_register(false));
}

void reg_frozen(Draw &draw)
{
    draw.lasts_any();
    draw.take_register(false);
    draw.fault().kind = RT_FAULT_FROZEN;
    draw.says(text("0x%08x is frozen", draw.fault().address));
}

void reg_write(Draw &draw)
{
    draw.lasts_any();
    draw.bits_of(draw.take_register(true));
    draw.fault().kind = RT_FAULT_WRITE;
    draw.drawn().what += " as written";
}

void reg_write_lost(Draw &draw)
{
    draw.lasts_any();
    draw.take_register(true);
    draw.fault().kind = RT_FAULT_WRITE_LOST;
    draw.says(text("0x%08x takes no writes", draw.fault().address));
}

void upset(Draw &draw, bool of_clocks)
{
    const auto &words = draw.survey().words;
    std::uint32_t i = 0;
    do i = draw.below(static_cast<std::uint32_t>(words.size()));
    while (of_clocks && !words[i].is_clock);
    draw.fault().kind = RT_FAULT_UPSET;
    draw.fault().address = i;
    draw.fault().flip = 1u << draw.below(words[i].bytes * 8u);
    draw.drawn().is_of_motor = words[i].is_motor || words[i].is_clock;
    draw.says(text("bit %08x of word %u, %s, flips", draw.fault().flip, i, words[i].part));
}

void reg_upset(Draw &draw)
{
    upset(draw, false);
}

void clock_upset(Draw &draw)
{
    upset(draw, true);
}

void reg_bus_error(Draw &draw)
{
    std::uint32_t mask = 0;
    draw.lasts(draw.one_of({3000.0, 0.0}));
    draw.fault().kind = RT_FAULT_BUS;
    draw.fault().address = draw.pick_register(draw.below(2) != 0, mask) & ~0x3fffu;
    draw.says(text("no answer from 0x%08x", draw.fault().address));
    draw.must(Must::power_off, SafeClass::processor);
}

// --- interrupts, clocks, power ---

void no_interrupt(Draw &draw)
{
    draw.lasts(draw.one_of({1500.0, 12000.0, 0.0}));
    draw.fault().kind = RT_FAULT_NO_INTERRUPT;
    draw.says("the tick's interrupt is lost");
    if (draw.is_at_least(long_us)) draw.must(Must::power_off, SafeClass::processor);
}

void more_ticks(Draw &draw)
{
    draw.fault().kind = RT_FAULT_INTERRUPT;
    draw.fault().address = RT_INTERRUPT_PIT;
    draw.says("the tick's interrupt comes once more");
}

void unexpected_interrupt(Draw &draw)
{
    draw.fault().kind = RT_FAULT_INTERRUPT;
    do draw.fault().address = draw.below(160);
    while (draw.fault().address == RT_INTERRUPT_PIT);
    draw.says(text("interrupt %u comes", draw.fault().address));
    draw.must(Must::power_off, SafeClass::processor);
}

void core_stands(Draw &draw)
{
    draw.lasts(draw.one_of({300.0, 2500.0, 12000.0, 0.0}));
    draw.fault().kind = RT_FAULT_CORE_STANDS;
    draw.drawn().is_of_motor = true; // the outputs keep their level
    draw.says("the processor's clock stands");
    if (draw.is_at_least(long_us)) draw.must(Must::power_off, SafeClass::processor);
}

void core_slow(Draw &draw)
{
    draw.lasts_any();
    draw.fault().kind = RT_FAULT_CORE_SLOW;
    draw.fault().set = draw.one_of({2u, 4u, 25u});
    draw.says(text("the processor's clock is %u times as slow", draw.fault().set));
}

void tick_rate(Draw &draw)
{
    draw.lasts_any();
    draw.fault().kind = RT_FAULT_TICK_RATE;
    draw.fault().set = draw.one_of({100u, 500u, 900u, 1100u, 2000u, 8000u});
    draw.says(text("a millisecond of the timer lasts %u us", draw.fault().set));
}

void brown_out(Draw &draw)
{
    draw.lasts(draw.one_of({10.0, 1000.0, 20000.0}));
    draw.fault().kind = RT_FAULT_POWER;
    draw.says("the supply of the chip breaks down");
    draw.must(Must::power_off, SafeClass::supply);
}

void watchdog_bites(Draw &draw)
{
    draw.fault().kind = draw.below(2) != 0 ? RT_FAULT_NO_INTERRUPT : RT_FAULT_EXCEPTION;
    draw.says(draw.fault().kind == RT_FAULT_EXCEPTION ? "a bus error" : "the tick's interrupt is lost");
    draw.must(Must::restart, SafeClass::processor);
    draw.drawn().horizon_ms = dog_horizon_ms;
}

// --- memories ---

void mem_code(Draw &draw)
{
    draw.memory("code", draw.survey().code);
}

void mem_code_any(Draw &draw)
{
    draw.memory("code", 0, draw.survey().code_end);
}

void mem_data(Draw &draw)
{
    draw.memory("data", draw.survey().data);
}

void mem_data_any(Draw &draw)
{
    draw.memory("data", RT_DTCM_BEGIN, draw.survey().bss_end);
}

// The words in use lie above the stack pointer of the moment.
void mem_stack(Draw &draw)
{
    draw.memory("stack, above its pointer,", 0, stack_used_bytes);
    draw.fault().set = 1;
}

void mem_dma(Draw &draw)
{
    draw.memory("USB memory", draw.survey().dma_begin, draw.survey().dma_end);
}

void mem_near(Draw &draw)
{
    draw.memory("near memory", 0x20220000u, 0x20280000u);
}

void mem_psram(Draw &draw)
{
    draw.memory("PSRAM", RT_PSRAM_BEGIN, RT_PSRAM_BEGIN + draw.survey().scene_bytes);
}

void psram_lost(Draw &draw)
{
    draw.lasts_any();
    draw.fault().kind = RT_FAULT_NO_PSRAM;
    draw.says("the PSRAM does not answer");
}

void mem_error(Draw &draw)
{
    draw.fault().kind = RT_FAULT_EXCEPTION;
    draw.says("a memory reports a bus error");
    draw.must(Must::power_off, SafeClass::processor);
}

// --- pins ---

void pin_stuck(Draw &draw)
{
    constexpr int pins[] = {RT_PIN_ENCODER_A0, RT_PIN_ENCODER_B0,     RT_PIN_ENCODER_A0 + 3,
                            RT_PIN_DIRECTION0, RT_PIN_DIRECTION0 + 1, RT_PIN_DRIVE,
                            RT_PIN_ENABLE,     RT_PIN_LAMP,           RT_PIN_STOP,
                            RT_PIN_PEDAL_XRAY, RT_PIN_UNLOCK,         RT_PIN_STAGE};
    draw.lasts_any();
    const int pin = draw.one_of(pins);
    rt_fault &fault = draw.fault();
    fault.kind = RT_FAULT_PIN;
    fault.address = static_cast<std::uint32_t>(pin);
    fault.set = draw.below(2);
    draw.says(text("the %s is stuck %s", rt_pin_name(static_cast<rt_pin>(pin)), fault.set ? "high" : "low"));
    draw.drawn().is_of_motor = pin == RT_PIN_DIRECTION0 || pin == RT_PIN_DIRECTION0 + 1;
    if (pin == RT_PIN_DRIVE && draw.is_at_least(long_us)) draw.must(Must::power_off, SafeClass::processor);
    const bool is_seen = draw.is_at_least(1500);
    if ((pin == RT_PIN_STOP && fault.set == 1 && is_seen) ||
        (pin == RT_PIN_STAGE && fault.set == 0 && is_seen) ||
        (pin == RT_PIN_ENABLE && fault.set == 0 && is_seen))
        draw.must(Must::power_off, SafeClass::sensors_and_forces);
}

void encoder_glitch(Draw &draw)
{
    draw.fault().kind = RT_FAULT_GLITCHES;
    draw.fault().address = draw.below(14);
    draw.fault().set = 1 + draw.below(60);
    draw.says(
        text("%u pulses on %s", draw.fault().set, rt_pin_name(static_cast<rt_pin>(draw.fault().address))));
}

void encoder_illegal(Draw &draw)
{
    draw.fault().kind = RT_FAULT_GLITCHES;
    draw.fault().address = used_encoder[draw.below(2)];
    draw.fault().set = 1 + draw.below(4);
    draw.fault().clear = 1;
    draw.says(text("%u pulses on both phases of encoder %u", draw.fault().set, draw.fault().address));
    draw.must(Must::power_off, SafeClass::sensors_and_forces);
}

void fault_line(Draw &draw)
{
    draw.lasts(draw.one_of({5.0, 200.0, 3000.0, 0.0}));
    draw.fault().kind = RT_FAULT_PIN;
    draw.fault().address = RT_PIN_FAULT;
    draw.fault().set = 0;
    draw.says("the fault line is low");
    draw.must(Must::power_off, SafeClass::sensors_and_forces);
}

void duty_stuck(Draw &draw)
{
    draw.fault().kind = RT_FAULT_DUTY;
    draw.fault().address = draw.below(6);
    draw.fault().set = draw.below(3) != 0;
    draw.drawn().is_of_motor = true;
    draw.says(text("motor %u has the duty %u", draw.fault().address, draw.fault().set));
    if (draw.fault().set != 0) draw.must(Must::power_off, SafeClass::sensors_and_forces);
}

// --- converters ---

void adc_stuck(Draw &draw)
{
    constexpr int pins[] = {RT_PIN_FORCE0, RT_PIN_CURRENT0, RT_PIN_SUPPLY, RT_PIN_PRESSURE};
    draw.lasts(draw.one_of({3500.0, 0.0}));
    draw.fault().kind = RT_FAULT_VOLTS;
    const int pin = draw.one_of(pins);
    draw.fault().address = static_cast<std::uint32_t>(pin);
    draw.fault().volts = draw.one_of({0.0, 3.3});
    draw.says(text("%s is stuck at %.1f V", rt_pin_name(static_cast<rt_pin>(pin)), draw.fault().volts));
    const bool is_harmless = pin == RT_PIN_PRESSURE || (pin == RT_PIN_CURRENT0 && draw.fault().volts == 0);
    if (!is_harmless) draw.must(Must::power_off, SafeClass::sensors_and_forces);
}

void adc_offset(Draw &draw)
{
    constexpr int pins[] = {RT_PIN_FORCE0, RT_PIN_FORCE0 + 1, RT_PIN_CURRENT0, RT_PIN_SUPPLY};
    draw.lasts_any();
    draw.fault().kind = RT_FAULT_VOLTS;
    draw.fault().address = static_cast<std::uint32_t>(draw.one_of(pins));
    draw.fault().set = 1;
    draw.fault().volts = draw.one_of({-1.0, -0.3, -0.05, 0.05, 0.3, 1.0});
    draw.says(text("%s has %+.2f V more", rt_pin_name(static_cast<rt_pin>(draw.fault().address)),
                   draw.fault().volts));
}

void adc_not_ready(Draw &draw)
{
    draw.lasts(draw.one_of({2500.0, 0.0}));
    draw.fault().kind = RT_FAULT_READ;
    draw.fault().address = (draw.below(2) != 0 ? BASE_ADC1 : BASE_ADC2) + ADC_HS;
    draw.fault().clear = MASK(ADC_HS_COCO0);
    draw.says("a converter never ends");
    draw.must(Must::power_off, SafeClass::sensors_and_forces);
}

// --- the bus ---

void usb(Draw &draw, rt_fault_kind kind, const char *name, bool is_final)
{
    draw.lasts(is_final ? 0.0 : draw.one_of({500.0, 15000.0, 0.0, 0.0}));
    draw.fault().kind = kind;
    draw.fault().set = draw.below(2);
    draw.fault().token = draw.survey().tokens + 1 + draw.below(300);
    draw.says(
        text("%s with token %u", name, static_cast<unsigned>(draw.fault().token - draw.survey().tokens)));
    draw.drawn().horizon_ms = usb_horizon_ms;
    if (draw.is_at_least(host_long_us) && kind != RT_FAULT_NOISE)
        draw.must(Must::no_force, SafeClass::host_silence);
}

void usb_reset(Draw &draw)
{
    usb(draw, RT_FAULT_BUS_RESET, "the bus is reset", true);
}
void usb_suspend(Draw &draw)
{
    usb(draw, RT_FAULT_SUSPEND, "the bus is suspended", false);
}
void usb_unplug(Draw &draw)
{
    usb(draw, RT_FAULT_UNPLUG, "the cable is pulled", false);
}
void usb_silence(Draw &draw)
{
    usb(draw, RT_FAULT_SILENCE, "no token arrives", false);
}
void usb_lost_ack(Draw &draw)
{
    usb(draw, RT_FAULT_LOST_ACK, "no handshake arrives", false);
}
void usb_noise(Draw &draw)
{
    usb(draw, RT_FAULT_NOISE, "half of the tokens are spoilt", false);
}

struct Kind {
    const char *name;
    std::uint32_t weight;
    void (*draw)(Draw &);
};
constexpr Kind kinds[] = {
    {"reg.read_bits", 12, reg_read},
    {"reg.frozen", 4, reg_frozen},
    {"reg.write_bits", 8, reg_write},
    {"reg.write_lost", 5, reg_write_lost},
    {"reg.upset", 16, reg_upset},
    {"reg.bus_error", 4, reg_bus_error},
    {"irq.lost", 3, no_interrupt},
    {"irq.tick_twice", 2, more_ticks},
    {"irq.unexpected", 4, unexpected_interrupt},
    {"clock.stands", 5, core_stands},
    {"clock.slow", 3, core_slow},
    {"clock.tick_rate", 3, tick_rate},
    {"clock.upset", 5, clock_upset},
    {"mem.code", 12, mem_code},
    {"mem.code_any", 2, mem_code_any},
    {"mem.data", 14, mem_data},
    {"mem.data_any", 3, mem_data_any},
    {"mem.stack", 4, mem_stack},
    {"mem.usb", 3, mem_dma},
    {"mem.near", 3, mem_near},
    {"mem.psram", 3, mem_psram},
    {"mem.psram_lost", 3, psram_lost},
    {"mem.bus_error", 2, mem_error},
    {"pin.stuck", 9, pin_stuck},
    {"pin.encoder_pulses", 5, encoder_glitch},
    {"pin.encoder_illegal", 4, encoder_illegal},
    {"pin.fault_line", 4, fault_line},
    {"motor.duty_stuck", 4, duty_stuck},
    {"adc.stuck", 5, adc_stuck},
    {"adc.offset", 4, adc_offset},
    {"adc.never_ready", 2, adc_not_ready},
    {"usb.reset", 4, usb_reset},
    {"usb.suspend", 3, usb_suspend},
    {"usb.unplug", 3, usb_unplug},
    {"usb.silence", 3, usb_silence},
    {"usb.lost_ack", 3, usb_lost_ack},
    {"usb.noise", 2, usb_noise},
    {"power.brown_out", 4, brown_out},
    {"watchdog.bites", 1, watchdog_bites},
};

// The kinds in an order in which every part of it has each of them according to its weight.
const Kind &kind_of(std::uint32_t seed)
{
    static const std::vector<const Kind *> order = [] {
        std::vector<std::pair<double, const Kind *>> places;
        for (const Kind &kind : kinds)
            for (std::uint32_t i = 0; i < kind.weight; i++)
                places.emplace_back((i + 0.5) / kind.weight, &kind);
        std::stable_sort(places.begin(), places.end(),
                         [](const auto &a, const auto &b) { return a.first < b.first; });
        std::vector<const Kind *> list;
        for (const auto &place : places) list.push_back(place.second);
        return list;
    }();
    return *order[seed % order.size()];
}

std::vector<std::uint32_t> touched_words(const std::uint8_t (&bits)[RT_TOUCHED_BYTES], std::uint32_t begin)
{
    std::vector<std::uint32_t> words;
    for (std::uint32_t i = 0; i < RT_FLEXRAM_BYTES / 4; i++)
        if ((bits[i / 8] >> i % 8 & 1u) != 0) words.push_back(begin + 4 * i);
    return words;
}

} // namespace

ChipSurvey survey_of(rt_engine &engine, const rt_touched &touched)
{
    ChipSurvey survey;
    std::vector<rt_word> words(RT_WORDS_MAX);
    words.resize(rt_fault_words(rt_engine_chip(&engine), words.data()));
    survey.words = words;
    survey.code = touched_words(touched.code, 0);
    survey.data = touched_words(touched.data, RT_DTCM_BEGIN);
    survey.code_end = rt_engine_symbol(&engine, "code_end");
    survey.bss_end = rt_engine_symbol(&engine, "bss_end");
    survey.dma_begin = rt_engine_symbol(&engine, "dma_begin");
    survey.dma_end = rt_engine_symbol(&engine, "dma_end");
    survey.scene_bytes = static_cast<std::uint32_t>(tube_scene().size());
    survey.tokens = rt_engine_chip(&engine)->usb.tokens;
    return survey;
}

ChipFault draw_chip_fault(std::uint32_t seed, const ChipSurvey &survey)
{
    ChipFault drawn;
    drawn.seed = seed;
    const Kind &kind = kind_of(seed);
    drawn.kind = kind.name;
    Draw draw(drawn, survey);
    kind.draw(draw);
    return drawn;
}

} // namespace hil
