#include "delivery_simulator.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// SplitMix64 (Steele et al. 2014, "Fast splittable pseudorandom number generators"), a step and its output.
std::uint64_t mixed(std::uint64_t state) {
    state += 0x9e3779b97f4a7c15;
    state = (state ^ state >> 30) * 0xbf58476d1ce4e5b9;
    state = (state ^ state >> 27) * 0x94d049bb133111eb;
    return state ^ state >> 31;
}

/// What a number is drawn for.
constexpr std::uint64_t of_jitter = 0, of_loss = 1;

std::optional<double> parsed_within(std::string_view text, double low, double high) {
    const std::optional<double> value = parsed_number(text);
    return value && *value >= low && *value <= high ? value : std::nullopt;
}

constexpr double longest_ms = 60000, longest_s = 86400;
/// Of times in a trace.
constexpr double farthest_s = 1e10;
/// Times in a trace are a frame's within that.
constexpr double same_frame_s = 1e-4;

struct Key {
    std::string_view name, value, expected, help;
    bool repeats;
    /// Whether the text is such a value.
    bool (*set)(std::string_view text, NetworkConditions& conditions);
};

constexpr bool (*set_stall)(std::string_view, NetworkConditions&) = [](std::string_view text,
                                                                       NetworkConditions& conditions) {
    const std::size_t colon = text.find(':');
    if (colon == text.npos)
        return false;
    const auto at_s = parsed_within(text.substr(0, colon), 0, longest_s);
    const auto lasts_s = parsed_within(text.substr(colon + 1), 0, longest_s);
    if (!at_s || !lasts_s)
        return false;
    conditions.stalls.push_back({*at_s, *lasts_s});
    return true;
};

template <double NetworkConditions::*Member>
bool set_ms(std::string_view text, NetworkConditions& conditions) {
    const auto ms = parsed_within(text, 0, longest_ms);
    if (ms)
        conditions.*Member = *ms / 1000;
    return ms.has_value();
}

/// Throws InputError naming file and line.
std::vector<TracedArrival> read_trace(const std::string& file) {
    std::ifstream in(file);
    if (!in)
        throw InputError(expected_found(file, "a trace of arrivals (CSV) that can be read", std::strerror(errno)));
    std::vector<TracedArrival> trace;
    std::string line;
    std::getline(in, line);
    if (trimmed(line) != "time_s,arrival_s")
        throw InputError(expected_found(file + ", line 1", "time_s,arrival_s", "'" + line.substr(0, 80) + "'"));
    for (std::size_t number = 2; std::getline(in, line); ++number) {
        if (trimmed(line).empty())
            continue;
        const auto fields = split_at_commas(line);
        const auto seconds = [&](std::size_t i) {
            return i < fields.size() ? parsed_within(trimmed(fields[i]), -farthest_s, farthest_s) : std::nullopt;
        };
        const auto sent_s = seconds(0), arrival_s = seconds(1);
        if (fields.size() != 2 || !sent_s || !arrival_s || (!trace.empty() && *sent_s <= trace.back().sent_s))
            throw InputError(expected_found(file + ", line " + std::to_string(number),
                                            "time_s,arrival_s in seconds, with time_s above that of the line before",
                                            "'" + line.substr(0, 80) + "'"));
        trace.push_back({*sent_s, *arrival_s});
    }
    if (trace.empty())
        throw InputError(expected_found(file, "at least one arrival", "none"));
    return trace;
}

const std::array<Key, 8> keys = {{
    {"delay", "MS", "milliseconds from 0 to 60000", "delay of every packet", false,
     set_ms<&NetworkConditions::delay_s>},
    {"jitter", "MS", "milliseconds from 0 to 60000", "random extra delay of each packet, at most", false,
     set_ms<&NetworkConditions::jitter_s>},
    {"loss", "SHARE", "a share from 0 to 0.9", "share of 1200-byte packets that is lost", false,
     [](std::string_view text, NetworkConditions& conditions) {
         const auto share = parsed_within(text, 0, 0.9);
         conditions.loss = share.value_or(0);
         return share.has_value();
     }},
    {"bandwidth", "MBIT/S", "megabits per second, above 0 and at most 1e6", "capacity of the link", false,
     [](std::string_view text, NetworkConditions& conditions) {
         const auto mbps = parsed_within(text, 1e-6, 1e6);
         conditions.bandwidth_bps = mbps.value_or(0) * 1e6;
         return mbps.has_value();
     }},
    {"stall", "AT:FOR", "seconds:seconds, each from 0 to 86400",
     "the server sends nothing from second AT of the stream on, for FOR seconds; may be given again", true, set_stall},
    {"transport", "KIND", "stream or datagrams",
     "stream (default): in order, a lost packet comes a round trip later; datagrams: any order, a lost packet stays "
     "lost",
     false,
     [](std::string_view text, NetworkConditions& conditions) {
         conditions.datagrams = text == "datagrams";
         return conditions.datagrams || text == "stream";
     }},
    {"seed", "N", "a whole number, not negative", "random seed", false,
     [](std::string_view text, NetworkConditions& conditions) {
         const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), conditions.seed);
         return error == std::errc() && end == text.data() + text.size();
     }},
    {"trace", "FILE", "a file",
     "instead of the others: CSV with time_s,arrival_s of each frame, as a real network delivered them", false,
     [](std::string_view text, NetworkConditions& conditions) {
         conditions.trace = read_trace(std::string(text));
         return true;
     }},
}};

}  // namespace

DeliverySimulator::DeliverySimulator(NetworkConditions conditions)
    : conditions_(std::move(conditions)), link_free_s_(-std::numeric_limits<double>::infinity()),
      last_arrival_s_(-std::numeric_limits<double>::infinity()) {
    std::ranges::sort(conditions_.stalls, {}, &NetworkStall::at_s);
}

/// From 0 to below 1.
double DeliverySimulator::uniform(std::uint64_t what, std::uint64_t which) const {
    return double(mixed(mixed(mixed(mixed(conditions_.seed) + frame_) + what) + which) >> 11) * 0x1p-53;
}

/// When something that takes `sending_s` to send, and may begin at `from_s`, has left.
double DeliverySimulator::leaves_s(double from_s, double sending_s) const {
    for (const NetworkStall& stall : conditions_.stalls) {
        if (stall.at_s + stall.lasts_s <= from_s)
            continue;
        if (from_s + sending_s < stall.at_s)
            break;
        sending_s -= std::max(0.0, stall.at_s - from_s);
        from_s = stall.at_s + stall.lasts_s;
    }
    return from_s + sending_s;
}

/// How often the unluckiest of a frame's packets is lost.
int DeliverySimulator::max_losses(std::int64_t packets) const {
    if (conditions_.loss <= 0)
        return 0;
    int most = 0;
    std::uint64_t draw = 0;
    for (std::int64_t packet = 0; packet < packets; ++packet) {
        int losses = 0;
        while (uniform(of_loss, draw++) < conditions_.loss)
            ++losses;
        most = std::max(most, losses);
    }
    return most;
}

/// Nothing: it is not in the trace.
std::optional<double> DeliverySimulator::traced(double sent_s) const {
    const auto found = std::ranges::lower_bound(conditions_.trace, sent_s - same_frame_s, {}, &TracedArrival::sent_s);
    if (found == conditions_.trace.end() || found->sent_s > sent_s + same_frame_s)
        return std::nullopt;
    return found->arrival_s;
}

std::optional<double> DeliverySimulator::send(double sent_s, std::int64_t bytes) {
    if (!conditions_.trace.empty())
        return traced(sent_s);
    const std::int64_t packets = std::max<std::int64_t>(1, (bytes + packet_bytes - 1) / packet_bytes);
    const double sending_s = conditions_.bandwidth_bps > 0 ? double(bytes) * 8 / conditions_.bandwidth_bps : 0;
    link_free_s_ = leaves_s(std::max(sent_s, link_free_s_), sending_s);
    double arrival_s = link_free_s_ + conditions_.delay_s + conditions_.jitter_s * uniform(of_jitter, 0);
    const int losses = max_losses(packets);
    ++frame_;
    if (conditions_.datagrams)
        return losses == 0 ? std::optional(arrival_s) : std::nullopt;
    arrival_s += losses * std::max(2 * conditions_.delay_s, shortest_round_trip_s);
    last_arrival_s_ = std::max(arrival_s, last_arrival_s_);
    return last_arrival_s_;
}

double DeliverySimulator::earliest_arrival_s(double sent_s) const {
    if (!conditions_.trace.empty()) {
        double earliest_s = std::numeric_limits<double>::infinity();
        for (const TracedArrival& one : conditions_.trace)
            if (one.sent_s >= sent_s - same_frame_s)
                earliest_s = std::min(earliest_s, one.arrival_s);
        return std::isinf(earliest_s) ? sent_s : earliest_s;  // what is lost is known at once
    }
    const double alone_s = leaves_s(std::max(sent_s, link_free_s_), 0) + conditions_.delay_s;
    return conditions_.datagrams ? alone_s : std::max(alone_s, last_arrival_s_);
}

NetworkConditions parse_network(const std::string& spec, const std::string& where) {
    NetworkConditions conditions;
    if (trimmed(spec).empty())
        return conditions;
    std::array<bool, keys.size()> given{};
    for (const std::string_view word : split_at_commas(spec)) {
        const std::size_t equals = word.find('=');
        const auto key = std::ranges::find(keys, trimmed(word.substr(0, equals)), &Key::name);
        if (equals == word.npos || key == keys.end()) {
            std::array<std::string, keys.size()> names;
            std::ranges::transform(keys, names.begin(),
                                   [](const Key& one) { return std::string(one.name) + "=" + std::string(one.value); });
            throw InputError(expected_found(where, in_a_sentence(names, " or "), "'" + std::string(word) + "'"));
        }
        bool& again = given[std::size_t(key - keys.begin())];
        const std::string name = where + " " + std::string(key->name);
        if (again && !key->repeats)
            throw InputError(expected_found(name, "one value", "a second one"));
        again = true;
        const std::string_view value = trimmed(word.substr(equals + 1));
        if (!key->set(value, conditions))
            throw InputError(expected_found(name, std::string(key->expected), "'" + std::string(value) + "'"));
    }
    if (!conditions.trace.empty() && std::ranges::count(given, true) > 1)
        throw InputError(expected_found(where + " trace", "trace as the only key", "'" + spec + "'"));
    return conditions;
}

std::string network_help() {
    std::string text;
    for (const Key& key : keys)
        text += formatted("%-18s %s\n", (std::string(key.name) + "=" + std::string(key.value)).c_str(),
                          std::string(key.help).c_str());
    return text;
}

}  // namespace equistream
