#include "delivery_simulator.h"

#include <equistream/comma_list.h>
#include <equistream/error.h>
#include <equistream/formatted.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace equistream {

namespace {

/// The whole of it.
template <typename Number>
std::optional<Number> parsed(std::string_view text) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<double> parsed_within(std::string_view text, double low, double high) {
    const std::optional<double> value = parsed<double>(text);
    return value && *value >= low && *value <= high ? value : std::nullopt;
}

constexpr double longest_ms = 60000, longest_s = 86400;

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

const std::array<Key, 7> keys = {{
    {"delay", "MS", "milliseconds from 0 to 60000", "every packet takes so long", false,
     set_ms<&NetworkConditions::delay_s>},
    {"jitter", "MS", "milliseconds from 0 to 60000", "and up to so much longer, at random", false,
     set_ms<&NetworkConditions::jitter_s>},
    {"loss", "SHARE", "a share from 0 to 0.9", "of packets, of 1200 bytes each, so many are lost", false,
     [](std::string_view text, NetworkConditions& conditions) {
         const auto share = parsed_within(text, 0, 0.9);
         conditions.loss = share.value_or(0);
         return share.has_value();
     }},
    {"bandwidth", "MBIT/S", "megabits per second, above 0 and at most 1e6", "the link carries no more", false,
     [](std::string_view text, NetworkConditions& conditions) {
         const auto mbps = parsed_within(text, 1e-6, 1e6);
         conditions.bandwidth_bps = mbps.value_or(0) * 1e6;
         return mbps.has_value();
     }},
    {"stall", "AT:FOR", "seconds:seconds, each from 0 to 86400",
     "from that second of the stream on nothing leaves for so many; may be given again", true, set_stall},
    {"transport", "KIND", "stream or datagrams",
     "stream (default): in order, what is lost comes a round trip later; datagrams: any order, what is lost is lost",
     false,
     [](std::string_view text, NetworkConditions& conditions) {
         conditions.datagrams = text == "datagrams";
         return conditions.datagrams || text == "stream";
     }},
    {"seed", "N", "a whole number, not negative", "of what is random", false,
     [](std::string_view text, NetworkConditions& conditions) {
         const auto seed = parsed<std::uint64_t>(text);
         conditions.seed = seed.value_or(0);
         return seed.has_value();
     }},
}};

}  // namespace

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
            throw InputError(expected_found(name, "one value", "another"));
        again = true;
        const std::string_view value = trimmed(word.substr(equals + 1));
        if (!key->set(value, conditions))
            throw InputError(expected_found(name, std::string(key->expected), "'" + std::string(value) + "'"));
    }
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
